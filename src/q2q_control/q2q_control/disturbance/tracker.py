"""Tracker of commands in transit, thrust and disturbances.

It joins q2q_control.disturbance.actuation and q2q_control.disturbance.observer for controllers that cancel
disturbances: the PID with an observer and the receding horizon.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.disturbance.actuation import Actuation, Pending
from q2q_control.disturbance.observer import DisturbanceObserver, Estimate, Measurement
from q2q_control.inputs.alignment import ETA, POS, QUAT, VEL, Aligned
from q2q_model.signals.values import Array, SwarmCommand, SwarmState, TrackStatus, index_of
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import Vehicle

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


class DisturbanceTracker:
    """Thrust, commands in transit, and disturbance estimates of every vehicle."""

    def __init__(self, params: TrackerParams, vehicle: Vehicle) -> None:
        """Track vehicles like `vehicle`."""
        self._actuation = Actuation(vehicle, params.latency)
        self._observer = DisturbanceObserver(
            params.state_bandwidth, params.observer_bandwidth, params.disturbance_max
        )
        self._eta = np.zeros((0, 3))

    def reset(self) -> None:
        """Forget everything."""
        self._actuation.reset()
        self._observer.reset()
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
        measured = Measurement(tick.t, tick.names, table[:, POS], table[:, VEL], explained, fresh)
        return Tracked(self._observer.update(measured), acc, self._actuation.pending())

    def sent(self, command: SwarmCommand, tick: Aligned) -> None:
        """Remember the tick's command."""
        self._actuation.sent(command, tick.table[:, QUAT])


def _tracked(state: SwarmState, tick: Aligned) -> NDArray[np.bool_]:
    tracked = state.status == _TRACKED
    if state.names == tick.names:
        return np.asarray(tracked)
    rows = index_of(tick.names, state.names)
    return np.asarray((rows >= 0) & np.append(tracked, False)[rows])
