"""Predicted paths that MPCs exchange, and the paths of neighbours as they are known now.

Every MPC sends the paths it has solved for its own vehicles, once in each slot of T
(q2q_control.mpc.neighbours.time_slots). A receiver interpolates the newest one from before its own tick, so
that a distributed flight does not depend on which of two messages of one tick arrives first. A path that is
older than T turns into what is known without it, and its position becomes uncertain:

    w = exp(-a / LATE_FADE),   r_j = w r_received + (1 - w) r_known,   sigma = (1 - w) TRACKING

r_known is the neighbour's reference or, without one, its measured position at constant velocity. The
uncertainty widens the downwash of the neighbour (q2q_control.mpc.prediction.downwash_horizon).

| symbol | name | meaning [unit] |
|---|---|---|
| a | late | time since the prediction, less T [s] |
| w | share | weight of the prediction [-] |
| sigma | spread | standard deviation of the horizontal position, each axis [m] |
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_control.inputs.alignment import Aligned
from q2q_control.mpc.neighbours.constant_velocity import FAR, Neighbours
from q2q_model.compiled import compiled
from q2q_model.counted import listed
from q2q_model.signals.cdr.cdr_head import MOST_VEHICLES
from q2q_model.signals.clock_resets import SET_BACK_S
from q2q_model.signals.stamps import SAME_STAMP
from q2q_model.signals.values import Array, Names, SwarmSetpoint, SwarmState, check_unique, rows_by_name

LATE_FADE = 0.2
"""Time constant of a late prediction [s]: that for which an MPC follows its own last solution by default."""
TRACKING = 0.05
"""Spread of a neighbour about its reference [m]: the default `tracking` of the safe replanner."""
SILENT = 5
"""Periods without a prediction after which a neighbour is silent: one or two are lost messages."""
MOST_POSITIONS = 401
"""Largest number of positions of a path: those of the longest horizon, `steps` of MpcParams."""
LEAST_STEP, MOST_AHEAD = 1e-3, 100.0
"""Minimum step, and maximum time from the tick to the start [s]: then integer steps do not overflow."""

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
        if len(self.names) > MOST_VEHICLES:
            raise ValueError(f"prediction of {len(self.names)} vehicles; must be at most {MOST_VEHICLES}")
        shape = self.pos.shape
        fits = len(shape) == 3 and shape[0] == len(self.names) and shape[2] == 3
        if not (fits and 2 <= shape[1] <= MOST_POSITIONS):
            raise ValueError(
                f"positions {shape} of {len(self.names)} vehicles; must be (n, 2 to {MOST_POSITIONS}, 3)"
            )
        if not (LEAST_STEP <= self.step < np.inf and abs(self.start - self.t) <= MOST_AHEAD):
            raise ValueError(
                f"t {self.t:g}, start {self.start:g}, step {self.step:g} s; start must be within "
                f"{MOST_AHEAD:g} s of t, and step finite and at least {LEAST_STEP:g} s"
            )
        if not np.isfinite(self.pos).all():
            raise ValueError(f"prediction of {listed(self.names)} is not finite: send finite positions")
        check_unique(self.names)
        if np.abs(self.pos).max() >= FAR:
            raise ValueError(f"prediction of {listed(self.names)}: positions must be within {FAR:g} m")


class ReceivedPath(NamedTuple):
    """Predicted path of one vehicle."""

    t: float
    start: float
    step: float
    """As those of PredictedPaths [s]."""
    pos: Array
    """[m], world, (N + 1, 3)."""


class ReceivedPredictions:
    """Newest predictions of every neighbour, of MOST_VEHICLES at most."""

    def __init__(self, period: float) -> None:
        """Start without predictions; a newer one is expected every `period` [s]."""
        self._period = period
        self._received: dict[str, list[ReceivedPath]] = {}

    def receive(self, prediction: PredictedPaths) -> None:
        """Take a prediction; the last two of a vehicle are kept, since one may be of the tick to come.

        Those later than it by more than SET_BACK_S are of a clock that was set back. With more than
        MOST_VEHICLES names the one that was received longest ago is forgotten.
        """
        for name, pos in zip(prediction.names, prediction.pos, strict=True):
            own = pos.astype(np.float64)  # a view would keep the paths of all vehicles of the message
            received = ReceivedPath(prediction.t, prediction.start, prediction.step, own)
            kept = [
                one
                for one in self._received.pop(name, [])
                if abs(one.t - received.t) > SAME_STAMP and one.t <= received.t + SET_BACK_S
            ]
            self._received[name] = sorted([*kept, received], key=lambda one: one.t)[-2:]
        while len(self._received) > MOST_VEHICLES:
            del self._received[next(iter(self._received))]

    def has(self, name: str, t: float) -> bool:
        """Return whether a prediction made at t [s] or later has arrived."""
        return any(one.t > t - SAME_STAMP for one in self._received.get(name, ()))

    def silent(self, state: SwarmState) -> Names:
        """Return the vehicles of `state` whose newest prediction is older than SILENT periods then."""
        oldest = state.t - SILENT * self._period
        known = (name for name in state.names if name in self._received)
        return tuple(sorted(name for name in known if self._received[name][-1].t < oldest))

    def follow(self, t: float, neighbours: Neighbours, times: Array) -> tuple[Neighbours, Array]:
        """Return neighbours on the predictions made before a tick at t [s], and the shares of those, (n,).

        Neighbours without a prediction, or out of reach, keep the paths they have, with a share of 0.
        """
        path, share = neighbours.path.copy(), np.zeros(len(neighbours.names))
        for row, name in enumerate(neighbours.names):
            received = self._before(t, name)
            if received is not None and abs(path[row, 0, 2]) < FAR:
                positions_at(received, times, path[row])
                share[row] = math.exp(-max(t - received.t - self._period - SAME_STAMP, 0.0) / LATE_FADE)
        return neighbours._replace(path=path, inputs=accelerations_along(path, times)), share

    def _before(self, t: float, name: str) -> ReceivedPath | None:
        """Return a vehicle's newest path from before t [s]."""
        return next((one for one in reversed(self._received.get(name, ())) if one.t < t - SAME_STAMP), None)


def blend(received: Neighbours, known: Neighbours, share: Array) -> Neighbours:
    """Return neighbours as predicted and as known without predictions, by the shares (n,) of these."""
    along = share[:, None, None]
    return known._replace(
        path=along * received.path + (1.0 - along) * known.path,
        inputs=along * received.inputs + (1.0 - along) * known.inputs,
        spread=(1.0 - share) * known.spread,
    )


def usable_prediction(tick: Aligned, path: Array, times: Array) -> PredictedPaths | None:
    """Return the prediction of a tick's usable vehicles, or None; `path` is (n, N + 1, 3) at `times`."""
    names = tuple(name for name, usable in zip(tick.names, tick.usable, strict=True) if usable)
    if not names:
        return None
    pos = path[tick.usable].astype(np.float32)
    return PredictedPaths(tick.t, names, float(times[0]), float(times[1] - times[0]), pos)


def known_neighbours(straight: Neighbours, setpoint: SwarmSetpoint, references: Array) -> Neighbours:
    """Return neighbours as known without predictions: on their references, if they have any.

    Args:
        straight: at constant velocity, far away if they have no state.
        setpoint: all vehicles that have one.
        references: of the vehicles of `setpoint`, (m, N + 1, 9).
    """
    names = straight.names
    if not names:
        return straight
    planned = rows_by_name(references, setpoint.names, names, np.nan)
    here = np.abs(straight.pos).max(axis=1) < FAR
    use = here & np.isfinite(planned).all(axis=(1, 2))
    row = use[:, None, None]
    return Neighbours(
        names=names,
        pos=straight.pos,
        path=np.where(row, planned[..., :3], straight.path),
        inputs=np.where(row, planned[:, :-1, 6:9], straight.inputs),
        spread=np.where(here, TRACKING, 0.0),
    )


@compiled
def positions_at(received: ReceivedPath, times: Array, path: Array) -> None:
    """Write the positions at `times` (K,) [s] to `path` (K, 3) [m], world.

    They are linear between stages and beyond the last one; before the first, they are the first.
    """
    last = received.pos.shape[0] - 1
    for k in range(times.size):
        place = max((times[k] - received.start) / received.step, 0.0)
        before = min(int(place), last - 1)
        share = place - before
        for axis in range(3):
            here = received.pos[before, axis]
            path[k, axis] = here + share * (received.pos[before + 1, axis] - here)


@compiled
def accelerations_along(path: Array, times: Array) -> Array:
    """Return the accelerations along paths (n, N + 1, 3), by second differences, (n, N, 3) [m/s^2].

    `times` (N + 1,) [s] have equal steps. The first stage has the acceleration of the second.
    """
    acc, square = np.empty((path.shape[0], times.size - 1, 3)), (times[2] - times[1]) ** 2
    for v in range(path.shape[0]):
        for k in range(1, times.size - 1):
            for axis in range(3):
                bend = path[v, k + 1, axis] - 2.0 * path[v, k, axis] + path[v, k - 1, axis]
                acc[v, k, axis] = bend / square
        acc[v, 0] = acc[v, 1]
    return acc
