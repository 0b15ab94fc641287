"""Downwash on vehicles without measurements: how much of the last known one is left.

Others above vehicle i were at offsets d_ij, horizontally, when its downwash was last known: predicted at its
place, or without a prediction part of its measured balance. What is left of it, as those move:

    share_i = mean_j exp(-|d_ij - d_ij(0)|^2 / W^2) exp(-t / B)       1 if nobody was above

A downwash is narrow, and an offset is dead-reckoned to a few centimetres: a vehicle that leaves it must not
be lifted any longer, as one that rises hits those above. Who comes above later is not known to push.

| symbol | name | meaning [unit] |
|---|---|---|
| W | WIDTH | width of a downwash [m] |
| t | - | time since the downwash was last known [s] |
| B | FADE_S | time in which it is forgotten [s] |
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, Names, index_of

Rows = NDArray[np.intp]
Mask = NDArray[np.bool_]

WIDTH = 0.076
"""Offset that leaves 1/e of a downwash [m]: sqrt(2) of the 54 mm of the measured jet (q2q_model.downwash)."""
FADE_S = 0.5
"""Time in which a downwash is forgotten [s]: a vehicle lifted out of it unnoticed rises to those above."""
REACH = 0.3
"""Horizontal distance within which a vehicle above counts [m]: four widths."""


class Places(NamedTuple):
    """Where the vehicles are."""

    names: Names
    pos: Array
    """[m], world, (n, 3)."""


class _Above(NamedTuple):
    """Those above a vehicle when its downwash was last known."""

    t: float
    """[s]"""
    offsets: dict[str, Array]
    """Horizontal [m], (2,) by name."""


class FadingDownwash:
    """Offsets of those above vehicles without measurements, when their downwash was last known."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all offsets."""
        self._above: dict[str, _Above] = {}

    def shares(self, blind: Rows, known: Mask, places: Places, t: float) -> Array:
        """Return what is left of the downwash of vehicles without measurements, from 0 to 1, (m,).

        Args:
            blind: their rows in `places`, (m,).
            known: those of them whose downwash is predicted where they are, (m,).
            places: dead-reckoned and measured positions.
            t: time of the tick [s].
        """
        above = {}
        for row, is_known in zip(blind, known, strict=True):
            now = _Above(t, _above(row, places))
            above[places.names[row]] = now if is_known else self._above.get(places.names[row], now)
        self._above = above
        return np.array([_share(one, row, places, t) for row, one in zip(blind, above.values(), strict=True)])


def _above(row: int, places: Places) -> dict[str, Array]:
    """Return the horizontal offsets of those that may push a vehicle down [m], (2,) by name."""
    apart = places.pos - places.pos[row]
    near = (np.hypot(apart[:, 0], apart[:, 1]) < REACH) & (apart[:, 2] > 0.0)
    return {places.names[other]: apart[other, :2] for other in np.flatnonzero(near)}


def _share(above: _Above, row: int, places: Places, t: float) -> float:
    """Return what is left of the downwash on a vehicle at t [s], from 0 to 1."""
    if not above.offsets:
        return 1.0
    others = index_of(tuple(above.offsets), places.names)
    now = np.vstack((places.pos, np.full(3, np.inf)))[others, :2] - places.pos[row, :2]
    moved = np.linalg.norm(now - np.array(list(above.offsets.values())), axis=1)
    return float(np.exp(-np.square(moved / WIDTH)).mean() * np.exp(-max(t - above.t, 0.0) / FADE_S))
