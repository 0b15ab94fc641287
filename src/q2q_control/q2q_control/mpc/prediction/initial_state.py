"""Initial state of the horizon: that in which a command given now finds the vehicles.

The tick's measurements, the thrust produced by earlier commands and the commands in transit
(q2q_control.disturbance.tracker), rolled forward by the latency with each axis' lag.
"""

from dataclasses import dataclass

import numpy as np

from q2q_control.disturbance.tracker import DisturbanceTracker, TrackerParams
from q2q_control.inputs.alignment import ETA, POS, VEL, Aligned
from q2q_control.mpc.problem.axis_model import axis_lags, lagged_step
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_model.compiled import compiled
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.signals.values import Array, SwarmCommand, SwarmImu
from q2q_model.vehicle.constants import Vehicle


@dataclass(frozen=True, slots=True)
class InitialState:
    """State in which a command given now finds the vehicles."""

    states: Array
    """Position, velocity, acceleration by thrust of each axis, (n, 3 axes, 3)."""
    disturbance: Array
    """Unexplained acceleration [m/s^2], world, (n, 3)."""
    residual: Array
    """Part of its z that fades within the correlation time [m/s^2], (n,)."""


class InitialStateEstimator:
    """Tracker of disturbances and of commands in transit."""

    def __init__(self, params: MpcParams, vehicle: Vehicle, residual_process: ResidualProcess | None) -> None:
        """Estimate vehicles like `vehicle`; `residual_process` is what accelerometers measure."""
        self._params, self._observes = params, params.observe or residual_process is not None
        self._lags = axis_lags(params, vehicle)
        tracker = TrackerParams(
            params.latency, params.state_bandwidth, params.observer_bandwidth, params.disturbance_max
        )
        self._tracker = DisturbanceTracker(tracker, vehicle, residual_process)

    def update(self, tick: Aligned) -> InitialState:
        """Return the initial state of the tick's vehicles."""
        tracked = self._tracker.update(tick)
        pos, vel, disturbance = tracked.estimate
        if not self._observes:
            pos, vel, disturbance = tick.table[:, POS], tick.table[:, VEL], np.zeros_like(disturbance)
        states = np.empty((*pos.shape, 3))
        states[..., 0], states[..., 1], states[..., 2] = pos, vel, tracked.acc
        if tracked.pending:
            push = tick.table[:, ETA] + disturbance
            for seconds, command in tracked.pending:
                roll_states(states, seconds, command.acc, push, self._lags)
        return InitialState(states, disturbance, tracked.residual)

    def sense(self, imu: SwarmImu) -> None:
        """Take accelerometers of a tick."""
        self._tracker.sense(imu)

    def sent(self, command: SwarmCommand, tick: Aligned) -> None:
        """Remember the tick's command."""
        self._tracker.sent(command, tick)


@compiled
def roll_states(
    states: Array, seconds: float, command: Array, push: Array, lags: tuple[float, float, float]
) -> None:
    """Move states (n, 3 axes, 3) on by a time [s] under a commanded acceleration and a push, (n, 3) [m/s^2].

    `lags` are those of x, y, z [s].
    """
    half = 0.5 * seconds * seconds
    for axis in range(3):
        keep, slow, late = lagged_step(lags[axis], seconds)
        for v in range(states.shape[0]):
            pos, vel, acc = states[v, axis, 0], states[v, axis, 1], states[v, axis, 2]
            u, w = command[v, axis], push[v, axis]
            states[v, axis, 0] = pos + seconds * vel + late * acc + (half - late) * u + half * w
            states[v, axis, 1] = vel + slow * acc + (seconds - slow) * u + seconds * w
            states[v, axis, 2] = keep * acc + (1.0 - keep) * u
