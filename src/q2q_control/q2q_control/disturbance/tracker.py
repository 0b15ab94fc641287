"""Tracker of commands in transit, thrust and disturbances.

It joins q2q_control.disturbance.actuation and q2q_control.disturbance.observer for controllers that cancel
disturbances: the PID with an observer and the receding horizon. With a residual process, the vertical
estimates are those of q2q_control.disturbance.residual_observer, which accelerometers correct (`sense`).
"""

from dataclasses import dataclass

import numpy as np

from q2q_control.attitude.command_delay import LATENCY_S
from q2q_control.disturbance.accelerometer_residual import AccelerometerResidual, ExplainedTick
from q2q_control.disturbance.actuation import Actuation, SentCommand
from q2q_control.disturbance.observer import (
    DisturbanceObserver,
    Estimate,
    MeasuredRows,
    Measurement,
    PlainRows,
)
from q2q_control.disturbance.residual_observer import CLIMB, HEIGHT, OFFSET, RESIDUAL, ResidualObserver
from q2q_control.disturbance.thrust_acceleration import thrust_acc_of_quat
from q2q_control.inputs.alignment import ETA, ETA_AT, POS_AT, QUAT, QUAT_AT, TRACK, VEL_AT, Aligned
from q2q_model.compiled import compiled
from q2q_model.downwash.correction.carried_by_rotors import is_carried
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.signals.values import (
    TRACKED,
    Array,
    Mask,
    Names,
    SwarmCommand,
    SwarmImu,
    rows_by_name,
)
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import GRAVITY, Vehicle


@dataclass(frozen=True, slots=True)
class TrackerParams:
    """Delay and lag of the command path, and bandwidths of the disturbance estimates."""

    latency: float = tunable(
        LATENCY_S, "delay from the stamp of a tick to the effect of its command", unit="s", low=0.0, high=0.3
    )
    state_bandwidth: float = tunable(
        20.0,
        "bandwidth of the estimates of position and velocity; larger values follow measurements faster",
        unit="rad/s",
        low=0.1,
        high=100.0,
    )
    observer_bandwidth: float = tunable(
        6.0,
        "bandwidth of the disturbance estimate; larger values follow changes faster, and pass more noise",
        unit="rad/s",
        low=0.01,
        high=50.0,
    )
    disturbance_max: float = tunable(
        3.0, "limit of the estimated disturbance", unit="m/s^2", low=0.0, high=9.81
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


@dataclass(frozen=True, slots=True)
class Tracked:
    """Estimates for the vehicles of one tick."""

    estimate: Estimate
    acc: Array
    """Acceleration by thrust now [m/s^2], world, (n, 3)."""
    pending: list[tuple[float, SentCommand]]
    """Commands in effect until one given now takes over, in order, with their durations [s]."""
    residual: Array
    """Part of the vertical disturbance that fades within the correlation time [m/s^2], (n,)."""


class DisturbanceTracker:
    """Thrust, commands in transit, and disturbance estimates of every vehicle."""

    def __init__(
        self, params: TrackerParams, vehicle: Vehicle, residual_process: ResidualProcess | None = None
    ) -> None:
        """Track vehicles like `vehicle`; `residual_process` is the residual that accelerometers measure."""
        self._residual_observer = None if residual_process is None else ResidualObserver(residual_process)
        self._accelerometers = AccelerometerResidual()
        self._most, self._vehicle = params.disturbance_max, vehicle
        self._actuation = Actuation(vehicle, params.latency)
        self._observer = DisturbanceObserver(
            params.state_bandwidth, params.observer_bandwidth, params.disturbance_max
        )
        self._names: Names = ()
        self._eta = np.zeros((0, 3))

    def reset(self) -> None:
        """Forget everything."""
        self._actuation.reset()
        self._observer.reset()
        self._accelerometers.reset()
        if self._residual_observer is not None:
            self._residual_observer.reset()
        self._names, self._eta = (), np.zeros((0, 3))

    def update(self, tick: Aligned) -> Tracked:
        """Return the estimates at the tick; `sent` must follow."""
        self._actuation.advance(tick.t, tick.names)
        before = rows_by_name(self._eta, self._names, tick.names, tick.table[:, ETA])
        thrusts = self._actuation.thrust, self._actuation.mean_thrust
        rows, acc, self._eta = measured_rows((tick.table, tick.usable), before, thrusts, self._vehicle.mass)
        self._names = tick.names
        measured = Measurement(tick.t, tick.names, MeasuredRows(*rows))
        estimate, residual = self._observer.update(measured), np.zeros(len(tick.names))
        if self._residual_observer is not None:
            eta, quat = self._eta[:, 2], tick.table[:, QUAT].copy()
            carried = is_carried(self._actuation.thrust, self._vehicle)
            vertical = self._residual_observer.update(measured, eta, carried)
            estimate, residual = _with_vertical(estimate, vertical, self._most), vertical[:, RESIDUAL]
            explained = np.where(carried, acc[:, 2] + GRAVITY + eta, np.nan)
            now = ExplainedTick(tick.t, tick.names, quat, explained)
            self._correct(self._accelerometers.explain(now))
        return Tracked(estimate, acc, self._actuation.pending(), residual)

    def sense(self, imu: SwarmImu) -> None:
        """Take accelerometers of a tick; they correct the estimates of the next one."""
        self._correct(self._accelerometers.sense(imu))

    def _correct(self, sample: tuple[float, Array] | None) -> None:
        if self._residual_observer is not None and sample is not None:
            self._residual_observer.correct_by_accelerometer(*sample)

    def sent(self, command: SwarmCommand, tick: Aligned) -> None:
        """Remember the tick's command."""
        self._actuation.sent(command, tick.table[:, QUAT])


def _with_vertical(estimate: Estimate, state: Array, most: float) -> Estimate:
    """Return the estimate with the height, climb rate and disturbance, at most `most`, of `state` (n, 5)."""
    pos, vel, disturbance = (part.copy() for part in estimate)
    pos[:, 2], vel[:, 2] = state[:, HEIGHT], state[:, CLIMB]
    disturbance[:, 2] = np.clip(state[:, RESIDUAL] + state[:, OFFSET], -most, most)
    return Estimate(pos, vel, disturbance)


@compiled
def measured_rows(
    tick: tuple[Array, Mask], before: Array, thrusts: tuple[Array, Array], mass: float
) -> tuple[PlainRows, Array, Array]:
    """Return a tick's measurements, the acceleration by thrust now and the downwash now [m/s^2], (n, 3).

    Args:
        tick: table of q2q_control.inputs.alignment, and which of its rows are usable, (n,).
        before: predicted downwash at the last tick [m/s^2], world, (n, 3).
        thrusts: thrust now, and its mean since the last tick [N], (n,).
        mass: of a vehicle [kg].
    """
    table, usable = tick
    n, quat = usable.size, table[:, QUAT_AT : QUAT_AT + 4]
    acc = thrust_acc_of_quat(quat, thrusts[0], mass)
    explained = thrust_acc_of_quat(quat, thrusts[1], mass)
    pos, vel, eta, fresh = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty(n, np.bool_)
    for v in range(n):
        fresh[v] = usable[v] and table[v, TRACK] == TRACKED
        for axis in range(3):
            pos[v, axis], vel[v, axis] = table[v, POS_AT + axis], table[v, VEL_AT + axis]
            eta[v, axis] = table[v, ETA_AT + axis]
            explained[v, axis] += 0.5 * (before[v, axis] + eta[v, axis])
    return (pos, vel, explained, fresh), acc, eta
