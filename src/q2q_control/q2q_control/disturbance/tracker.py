"""Tracker of commands in transit, thrust and disturbances.

It joins q2q_control.disturbance.actuation and q2q_control.disturbance.observer for controllers that cancel
disturbances: the PID with an observer and the receding horizon. With a residual process, the vertical
estimates are those of q2q_control.disturbance.residual_observer, which accelerometers correct (`sense`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.disturbance.actuation import Actuation, Pending
from q2q_control.disturbance.felt_push import ExplainedTick, FeltPush
from q2q_control.disturbance.observer import DisturbanceObserver, Estimate, Measurement
from q2q_control.disturbance.residual_observer import CLIMB, HEIGHT, OFFSET, RESIDUAL, ResidualObserver
from q2q_control.inputs.alignment import ETA, POS, QUAT, VEL, Aligned
from q2q_model.downwash.residual_process import ResidualProcess
from q2q_model.signals.values import Array, SwarmCommand, SwarmImu, SwarmState, TrackStatus, index_of
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import GRAVITY, Vehicle

_TRACKED = int(TrackStatus.TRACKED)


@dataclass(frozen=True, slots=True)
class TrackerParams:
    """Delay and lag of the command path, and bandwidths of the disturbance estimates."""

    latency: float = tunable(0.026, "tick's stamp to its command's effect", unit="s", low=0.0, high=0.3)
    state_bandwidth: float = tunable(
        20.0, "bandwidth of estimated position and velocity", unit="rad/s", low=0.1, high=100.0
    )
    observer_bandwidth: float = tunable(
        6.0, "bandwidth of the estimated disturbance", unit="rad/s", low=0.01, high=50.0
    )
    disturbance_max: float = tunable(3.0, "largest estimated disturbance", unit="m/s^2", low=0.0, high=9.81)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


@dataclass(frozen=True, slots=True)
class Tracked:
    """Estimates for the vehicles of one tick."""

    estimate: Estimate
    acc: Array
    """Acceleration by thrust now [m/s^2], world, (n, 3)."""
    pending: Pending
    """Commands that take effect before one given now."""
    residual: Array
    """Part of the vertical disturbance that fades within the correlation time [m/s^2], (n,)."""


class DisturbanceTracker:
    """Thrust, commands in transit, and disturbance estimates of every vehicle."""

    def __init__(
        self, params: TrackerParams, vehicle: Vehicle, correct: ResidualProcess | None = None
    ) -> None:
        """Track vehicles like `vehicle`; `correct` is the residual that accelerometers measure."""
        self._fine = None if correct is None else ResidualObserver(correct)
        self._felt = FeltPush()
        self._most = params.disturbance_max
        self._actuation = Actuation(vehicle, params.latency)
        self._observer = DisturbanceObserver(
            params.state_bandwidth, params.observer_bandwidth, params.disturbance_max
        )
        self._eta = np.zeros((0, 3))

    def reset(self) -> None:
        """Forget everything."""
        self._actuation.reset()
        self._observer.reset()
        self._felt.reset()
        if self._fine is not None:
            self._fine.reset()
        self._eta = np.zeros((0, 3))

    def update(self, tick: Aligned, state: SwarmState) -> Tracked:
        """Return the estimates at the tick; `sent` must follow."""
        table = tick.table
        self._actuation.advance(tick.t, tick.names)
        acc, mean = self._actuation.accelerations(table[:, QUAT])
        eta = table[:, ETA].copy()
        before = self._eta if self._eta.shape == eta.shape else eta
        self._eta = eta
        fresh = tick.usable & _tracked(state, tick)
        explained = mean + 0.5 * (before + eta)
        pos, vel = table[:, POS].copy(), table[:, VEL].copy()  # one layout, also of a single vehicle
        measured = Measurement(tick.t, tick.names, pos, vel, explained, fresh)
        estimate, residual = self._observer.update(measured), np.zeros(len(tick.names))
        if self._fine is not None:
            vertical = self._fine.update(measured, eta[:, 2])
            estimate, residual = _with_vertical(estimate, vertical, self._most), vertical[:, RESIDUAL]
            now = ExplainedTick(tick.t, tick.names, table[:, QUAT].copy(), acc[:, 2] + GRAVITY + eta[:, 2])
            self._correct(self._felt.explain(now))
        return Tracked(estimate, acc, self._actuation.pending(), residual)

    def sense(self, imu: SwarmImu) -> None:
        """Take accelerometers of a tick; they correct the estimates of the next one."""
        self._correct(self._felt.sense(imu))

    def _correct(self, felt: tuple[float, Array] | None) -> None:
        if self._fine is not None and felt is not None:
            self._fine.feel(*felt)

    def sent(self, command: SwarmCommand, tick: Aligned) -> None:
        """Remember the tick's command."""
        self._actuation.sent(command, tick.table[:, QUAT])


def _with_vertical(estimate: Estimate, state: Array, most: float) -> Estimate:
    """Return the estimate with the height, climb rate and disturbance, at most `most`, of `state` (n, 4)."""
    pos, vel, disturbance = (part.copy() for part in estimate)
    pos[:, 2], vel[:, 2] = state[:, HEIGHT], state[:, CLIMB]
    disturbance[:, 2] = np.clip(state[:, RESIDUAL] + state[:, OFFSET], -most, most)
    return Estimate(pos, vel, disturbance)


def _tracked(state: SwarmState, tick: Aligned) -> NDArray[np.bool_]:
    tracked = state.status == _TRACKED
    if state.names == tick.names:
        return np.asarray(tracked)
    rows = index_of(tick.names, state.names)
    return np.asarray((rows >= 0) & np.append(tracked, False)[rows])
