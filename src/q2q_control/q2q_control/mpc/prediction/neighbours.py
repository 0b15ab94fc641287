"""Predicted paths that MPCs exchange, and the paths of neighbours as they are known now.

Every MPC sends the paths it has solved for its own vehicles. A receiver interpolates the newest one from
before its own tick, so that a distributed flight does not depend on which of two messages of one tick arrives
first. A path that is later than the usual tick turns into what is known without it, and its position becomes
uncertain:

    w = exp(-a / FADE),   r_j = w r_heard + (1 - w) r_known,   sigma = (1 - w) TRACKING

r_known is the neighbour's reference or, without one, its measured position at constant velocity. The
uncertainty widens the downwash of the neighbour (q2q_control.mpc.prediction.downwash_horizon).

| symbol | name | meaning [unit] |
|---|---|---|
| a | age | time since the prediction, less one tick [s] |
| w | share | weight of the prediction [-] |
| sigma | spread | standard deviation of the horizontal position, each axis [m] |
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.inputs.alignment import Aligned
from q2q_control.mpc.prediction.surroundings import FAR, Neighbours
from q2q_model.signals.values import Array, Names, SwarmSetpoint, SwarmState, index_of

FADE = 0.2
"""Time constant of a late prediction [s]: the MPC's shift_time, as long as it follows its own last plan."""
TRACKING = 0.05
"""Spread of a neighbour about its reference [m]: the `tracking` of the safe replanner."""
TICK = 0.01
"""Age of a prediction that is not late [s]: the 100 Hz tick."""
SAME = 1e-6
"""Two stamps that differ by less [s] are the same."""
CLOCK_JUMP = 1.0
"""A prediction older than the last one by more [s] is of a clock that was set back."""

Positions = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class PredictedPaths:
    """Predicted paths of the vehicles of one MPC."""

    t: float
    """Stamp of its tick [s]."""
    names: Names
    start: float
    """Time of the first position [s]."""
    step: float
    """Time between positions [s]."""
    pos: Positions
    """[m], world, (n, N + 1, 3); float32, exact to 1 um within 10 m, halves the message."""

    def __post_init__(self) -> None:
        """Refuse what cannot be interpolated."""
        shape = self.pos.shape
        if len(shape) != 3 or shape[0] != len(self.names) or shape[1] < 2 or shape[2] != 3:
            raise ValueError(
                f"positions {shape} of {len(self.names)} vehicles: (n, 2 or more, 3) is expected"
            )
        if not (0.0 < self.step < np.inf and np.isfinite(self.start) and np.isfinite(self.t)):
            raise ValueError(f"t {self.t:g}, start {self.start:g}, step {self.step:g}: finite, step above 0")
        if not np.isfinite(self.pos).all():
            raise ValueError(f"prediction of {', '.join(self.names)} is not finite: send finite positions")


class HeardPredictions:
    """Newest predictions of every neighbour."""

    def __init__(self) -> None:
        """Start without predictions."""
        self._heard: dict[str, list[tuple[PredictedPaths, int]]] = {}

    def reset(self) -> None:
        """Forget all predictions."""
        self._heard.clear()

    def hear(self, prediction: PredictedPaths) -> None:
        """Take a prediction; the last two of a vehicle are kept, since one may be of the tick to come."""
        for row, name in enumerate(prediction.names):
            kept = [
                one
                for one in self._heard.get(name, [])
                if abs(one[0].t - prediction.t) > SAME and one[0].t < prediction.t + CLOCK_JUMP
            ]
            kept.append((prediction, row))
            self._heard[name] = sorted(kept, key=lambda one: one[0].t)[-2:]

    def has(self, name: str, t: float) -> bool:
        """Return whether a prediction made at t [s] or later has arrived."""
        return any(one.t > t - SAME for one, _ in self._heard.get(name, ()))

    def neighbours(self, t: float, known: Neighbours, times: Array) -> Neighbours:
        """Return `known` with the predictions made before a tick at t [s], at the stages' `times` [s]."""
        path, inputs, spread = known.path.copy(), known.inputs.copy(), known.spread.copy()
        for row, name in enumerate(known.names):
            before = [one for one in self._heard.get(name, ()) if one[0].t < t - SAME]
            if not before or known.spread[row] == 0.0:
                continue
            prediction, at = before[-1]
            share = np.exp(-max(t - prediction.t - TICK - SAME, 0.0) / FADE)
            heard = interpolated(prediction, at, times)
            path[row] = share * heard + (1.0 - share) * path[row]
            inputs[row] = share * _accelerations(heard, times) + (1.0 - share) * inputs[row]
            spread[row] *= 1.0 - share
        return known._replace(path=path, inputs=inputs, spread=spread)


def predicted(tick: Aligned, path: Array, times: Array) -> PredictedPaths | None:
    """Return the prediction of a tick's usable vehicles, or None; `path` is (n, N + 1, 3) at `times`."""
    names = tuple(name for name, usable in zip(tick.names, tick.usable, strict=True) if usable)
    if not names:
        return None
    pos = path[tick.usable].astype(np.float32)
    return PredictedPaths(tick.t, names, float(times[0]), float(times[1] - times[0]), pos)


def known_neighbours(
    straight: Neighbours, state: SwarmState, setpoint: SwarmSetpoint, references: Array
) -> Neighbours:
    """Return neighbours as known without predictions: on their references, if they have any.

    Args:
        straight: at constant velocity, far away if they have no state.
        state: all vehicles.
        setpoint: all vehicles that have one.
        references: of the vehicles of `setpoint`, (m, N + 1, 9).
    """
    names = straight.names
    if not names:
        return straight
    rows, among = index_of(names, state.names), index_of(names, setpoint.names)
    planned = references[among]
    here = np.abs(straight.pos).max(axis=1) < FAR
    use = here & (among >= 0) & np.isfinite(planned).all(axis=(1, 2))
    row = use[:, None, None]
    return Neighbours(
        names=names,
        pos=np.where(here[:, None], state.pos[rows], straight.pos),
        path=np.where(row, planned[..., :3], straight.path),
        inputs=np.where(row, planned[:, :-1, 6:9], straight.inputs),
        spread=np.where(here, TRACKING, 0.0),
    )


def interpolated(prediction: PredictedPaths, row: int, times: Array) -> Array:
    """Return one vehicle's positions at `times`, linear between stages and beyond the ends, (K, 3)."""
    pos = prediction.pos[row].astype(np.float64)
    place = (times - prediction.start) / prediction.step
    before = np.clip(np.floor(place), 0, len(pos) - 2).astype(np.intp)
    share = (place - before)[:, None]
    return np.asarray(pos[before] + share * (pos[before + 1] - pos[before]))


def _accelerations(path: Array, times: Array) -> Array:
    """Return the accelerations along a path (N + 1, 3), by second differences, (N, 3)."""
    acc = np.empty((len(path) - 1, 3))
    acc[1:] = np.diff(path, 2, axis=0) / (times[2] - times[1]) ** 2
    acc[0] = acc[1]
    return acc
