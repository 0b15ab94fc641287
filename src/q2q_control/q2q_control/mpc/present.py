"""Say where the vehicles will be when a command given now starts to act.

From the tick's measurements, the thrust that has come of earlier commands, and the commands still on their
way (q2q_control.actuation), rolled forward by the latency with each axis' lag.
"""

from dataclasses import dataclass

import numpy as np

from q2q_control.actuation import Actuation
from q2q_control.alignment import ETA, POS, QUAT, VEL, Aligned
from q2q_control.mpc.chain import transition
from q2q_control.mpc.params import MpcParams
from q2q_control.observer import DisturbanceObserver, Measurement
from q2q_model.signals import Array, SwarmCommand, SwarmState, TrackStatus, index_of
from q2q_model.vehicle import Vehicle


@dataclass(frozen=True, slots=True)
class Present:
    """Hold the state in which a command given now finds the vehicles."""

    t: float
    """[s]: the tick's stamp plus the latency."""
    chains: Array
    """Position, velocity, acceleration by thrust of each axis, (n, 3 axes, 3)."""
    disturbance: Array
    """Unexplained acceleration [m/s^2], world, (n, 3)."""


class PresentEstimator:
    """Hold the observer and the commands on their way."""

    def __init__(self, params: MpcParams, vehicle: Vehicle) -> None:
        """Estimate vehicles like `vehicle`."""
        self._params = params
        self._lags = axis_lags(params, vehicle)
        self._actuation = Actuation(vehicle, params.latency)
        self._observer = DisturbanceObserver(params.observer_bandwidth, params.disturbance_max)
        self._eta = np.zeros((0, 3))

    def update(self, tick: Aligned, state: SwarmState) -> Present:
        """Return the present of the tick's vehicles."""
        table = tick.table
        self._actuation.advance(tick.t, tick.names)
        acc, mean = self._actuation.accelerations(table[:, QUAT])
        eta = table[:, ETA]
        before = self._eta if self._eta.shape == eta.shape else eta
        self._eta = eta
        pos, vel, disturbance = table[:, POS], table[:, VEL], np.zeros_like(acc)
        if self._params.observe:
            fresh = tick.usable & _tracked(state, tick)
            seen = Measurement(tick.t, tick.names, pos, vel, mean + 0.5 * (before + eta), fresh)
            estimate = self._observer.update(seen)
            pos, vel, disturbance = estimate.pos, estimate.vel, estimate.disturbance
        chains = np.stack([pos, vel, acc], axis=-1)
        return self._rolled(tick, chains, disturbance)

    def sent(self, command: SwarmCommand, tick: Aligned) -> None:
        """Remember the tick's command."""
        self._actuation.sent(command, tick.table[:, QUAT])

    def _rolled(self, tick: Aligned, chains: Array, disturbance: Array) -> Present:
        push = tick.table[:, ETA] + disturbance
        pending = self._actuation.pending()
        for seconds, acc in zip(pending.durations, pending.acc, strict=True):
            chains = _moved(chains, seconds, (acc, push), self._lags)
        return Present(tick.t + self._params.latency, chains, disturbance)


def axis_lags(params: MpcParams, vehicle: Vehicle) -> tuple[float, float, float]:
    """Return how far x, y, z accelerations are behind their commands [s]."""
    side = params.attitude_lag + vehicle.thrust_lag
    return side, side, vehicle.thrust_lag


def _moved(
    chains: Array, seconds: float, drive: tuple[Array, Array], lags: tuple[float, float, float]
) -> Array:
    command, push = drive
    moved = np.empty_like(chains)
    gain = np.array([0.5 * seconds * seconds, seconds, 0.0])
    for axis, lag in enumerate(lags):
        a, b = transition(lag, seconds)
        moved[:, axis] = chains[:, axis] @ a.T + command[:, axis, None] * b + push[:, axis, None] * gain
    return moved


def _tracked(state: SwarmState, tick: Aligned) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    tracked = state.status == int(TrackStatus.TRACKED)
    return (
        tracked if state.names == tick.names else np.append(tracked, False)[index_of(tick.names, state.names)]
    )
