"""Downwash on vehicles without measurements: how much of the last known one is left.

Others above vehicle i were at offsets d_ij, horizontally, when its downwash was last known: predicted at its
place, and the rest of it a part of its measured trim. What is left of both, as those move:

    share_i = mean_j exp(-|d_ij - d_ij(0)|^2 / W^2) exp(-t / B)       1 if nobody was above

A downwash is narrow, and an offset is dead-reckoned to a few centimetres: a vehicle that leaves it must not
be lifted any longer, as one that rises hits those above. One that comes above later is not known to push.

| symbol | name | meaning [unit] |
|---|---|---|
| W | JET_WIDTH | width of a downwash [m] |
| t | - | time since the downwash was last known [s] |
| B | FADE_S | time in which it is forgotten [s] |
"""

from typing import NamedTuple

import numpy as np

from q2q_control.failsafe.tracking_loss.stacking import stacked_pairs
from q2q_model.signals.values import Array, Mask, Names, Rows, index_of, rows_by_name

JET_WIDTH = 0.076
"""Offset that leaves 1/e of a downwash [m]: sqrt(2) of the 54 mm of the measured jet (q2q_model.downwash)."""
FADE_S = 0.5
"""Time in which a downwash is forgotten [s]: a vehicle lifted out of it unnoticed rises to those above."""
ABOVE_RADIUS = 0.5
"""Horizontal distance within which a vehicle above counts [m]: four widths, 0.3, and what it moves by at
0.8 m/s while the trim still holds its downwash, 0.25 s (2 / OBSERVER, vertically; dead_reckoning)."""


class Places(NamedTuple):
    """Where the vehicles are."""

    names: Names
    pos: Array
    """[m], world, (n, 3)."""


class _Above(NamedTuple):
    """Those above vehicles when their downwash was last known, by rows of the places, (p,) each."""

    below: Rows
    above: Rows
    """-1: it has left the swarm since then."""
    offset: Array
    """Horizontal [m], (p, 2)."""

    def of(self, chosen: Mask) -> "_Above":
        """Return the chosen pairs (p,)."""
        return _Above(self.below[chosen], self.above[chosen], self.offset[chosen])

    def joined(self, other: "_Above") -> "_Above":
        """Return these pairs and others."""
        below, above = np.append(self.below, other.below), np.append(self.above, other.above)
        return _Above(below, above, np.vstack((self.offset, other.offset)))


class _Known(NamedTuple):
    """A tick at which the downwash of every vehicle without measurements was known."""

    unmeasured: Rows
    """Their rows in `pos`, (m,)."""
    pos: Array
    """[m], world, (n, 3)."""
    t: float
    """[s]"""


class FadingDownwash:
    """Offsets of those above vehicles without measurements, when their downwash was last known."""

    def __init__(self) -> None:
        self._names: Names = ()
        self._known_at = np.zeros(0)  # [s]; NaN: a measured vehicle
        self._above = _above(np.zeros((0, 3)), np.zeros(0, np.intp))
        self._last: _Known | None = None  # whose offsets are taken when one is no longer known

    def set_back(self, by: float) -> None:
        """Shift stored times back by `by` [s]: the clock was."""
        self._take_offsets()
        self._known_at = self._known_at - by

    def shares(self, unmeasured: Rows, known: Mask, places: Places, t: float) -> Array:
        """Return what is left of the downwash of vehicles without measurements, from 0 to 1, (m,).

        Args:
            unmeasured: their rows in `places`, (m,).
            known: those of them whose downwash is predicted where they are, (m,).
            places: dead-reckoned and measured positions.
            t: time of the tick [s].
        """
        if known.all():
            self._names, self._last = places.names, _Known(unmeasured, places.pos, t)
            return np.ones(unmeasured.size)
        self._take_offsets()
        self._match(places.names)
        begun = known | np.isnan(self._known_at[unmeasured])
        known_at = np.full(len(places.names), np.nan)
        known_at[unmeasured] = np.where(begun, t, self._known_at[unmeasured])
        kept = np.zeros(len(places.names), np.bool_)
        kept[unmeasured] = ~begun
        kept_pairs = self._above.of(kept[self._above.below])
        self._above, self._known_at = kept_pairs.joined(_above(places.pos, unmeasured[begun])), known_at
        return _left(self._above, places.pos, t - known_at)[unmeasured]

    def _take_offsets(self) -> None:
        """Take the offsets of the last tick at which all were known, if that was the last tick."""
        if self._last is None:
            return
        unmeasured, pos, t = self._last
        self._known_at, self._last = np.full(len(pos), np.nan), None
        self._known_at[unmeasured], self._above = t, _above(pos, unmeasured)

    def _match(self, names: Names) -> None:
        """Match the stored rows to `names`."""
        if names == self._names:
            return
        rows = np.append(index_of(self._names, names), -1)
        below, above, offset = self._above
        moved = _Above(rows[below], rows[above], offset)
        self._above = moved.of(moved.below >= 0)
        self._known_at = rows_by_name(self._known_at, self._names, names, np.nan)
        self._names = names


def _above(pos: Array, below: Rows) -> _Above:
    """Return those that may push some vehicles down."""
    pairs = stacked_pairs(pos, below, ABOVE_RADIUS, 0.0)
    return _Above(pairs.below, pairs.above, pos[pairs.above, :2] - pos[pairs.below, :2])


def _left(known: _Above, pos: Array, age: Array) -> Array:
    """Return what is left of the downwash on each vehicle, `age` [s] after it was known, (n,)."""
    if not known.below.size:
        return np.ones(age.size)
    now = np.vstack((pos, np.full(3, np.inf)))[known.above, :2] - pos[known.below, :2]
    share = np.exp(-np.square(np.linalg.norm(now - known.offset, axis=1) / JET_WIDTH))
    total, count = (np.bincount(known.below, one, age.size) for one in (share, np.ones(share.size)))
    return np.where(count > 0.0, total / np.maximum(count, 1.0) * np.exp(-np.maximum(age, 0.0) / FADE_S), 1.0)
