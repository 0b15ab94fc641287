"""Last known state of every vehicle: those of the swarm and external ones.

A vehicle that vanishes from the state keeps its last known state, with growing age, until it is forgotten.
Where the clock is set back by x, measurements count as made x earlier: ages neither shrink nor stop, and the
next measurement is newer.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import KNOWN_NAMES, Array, Mask, Names, Rows, SwarmState, index_of

UNKNOWN = -np.inf
"""Stamp of a vehicle whose state is not known [s]."""


@dataclass(frozen=True, slots=True)
class KnownStates:
    """Last known states of some vehicles."""

    names: Names
    pos: Array
    """Measured position [m], (n, 3)."""
    vel: Array
    """Measured velocity [m/s], (n, 3)."""
    age: Array
    """Age of the measurement [s], (n,)."""


NOBODY = KnownStates((), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


class _Rows(NamedTuple):
    """States of some vehicles."""

    pos: Array
    vel: Array
    stamp: Array
    """Time of the measurement [s], (n,)."""


class LastKnownStates:
    """Memory of the last known states."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all vehicles."""
        self._names: Names = ()
        self._rows = _Rows(NOBODY.pos, NOBODY.vel, NOBODY.age)

    def set_back(self, by: float) -> None:
        """Date the states by a clock that was set back [s]."""
        self._rows.stamp[:] -= by

    def update(self, state: SwarmState) -> None:
        """Store a state; rows with NaN, or not newer than the stored one, are ignored."""
        self._expect(state.names)
        measured = _Rows(np.array(state.pos), np.array(state.vel), state.t - state.age)
        _take_newest(self._rows, measured, index_of(state.names, self._names))

    def forget(self, t: float, oldest: float) -> Names:
        """Forget the states older than `oldest` [s] at t [s]; return the vehicles that had been measured."""
        old = t - self._rows.stamp > oldest
        if not old.any():
            return ()
        measured = old & np.isfinite(self._rows.stamp)
        forgotten = tuple(name for name, gone in zip(self._names, measured, strict=True) if gone)
        self._keep(~old)
        return forgotten

    def external(self, swarm: Names, t: float) -> KnownStates:
        """Return the states of all vehicles outside the swarm."""
        others = _others(self._names, swarm)
        return self.of(others, t) if others else NOBODY

    def of(self, names: Names, t: float) -> KnownStates:
        """Return the states of these vehicles; NaN with infinite age for an unknown one."""
        self._expect(names)
        found = self._rows if names == self._names else self._at(index_of(names, self._names))
        return KnownStates(names, found.pos, found.vel, np.maximum(t - found.stamp, 0.0))

    def _at(self, rows: Rows | Mask) -> _Rows:
        pos, vel, stamp = self._rows
        return _Rows(pos[rows], vel[rows], stamp[rows])

    def _expect(self, names: Names) -> None:
        """Add unknown states of vehicles that are new."""
        if names == self._names:
            return
        new = _others(tuple(dict.fromkeys(names)), self._names)
        unknown = np.full((len(new), 3), np.nan)
        pos, vel, stamp = self._rows
        self._names += new
        self._rows = _Rows(
            np.concatenate([pos, unknown]),
            np.concatenate([vel, unknown]),
            np.concatenate([stamp, np.full(len(new), UNKNOWN)]),
        )

    def _keep(self, kept: Mask) -> None:
        """Forget all other rows."""
        self._names = tuple(name for name, stays in zip(self._names, kept, strict=True) if stays)
        self._rows = self._at(kept)


@compiled
def _take_newest(known: _Rows, measured: _Rows, rows: Rows) -> None:
    """Update known states by finite ones that are newer; `rows` are their rows there, (m,)."""
    for row in range(rows.size):
        there = rows[row]
        finite = np.isfinite(measured.stamp[row])
        for axis in range(3):
            finite &= np.isfinite(measured.pos[row, axis]) and np.isfinite(measured.vel[row, axis])
        if finite and measured.stamp[row] > known.stamp[there]:
            known.pos[there], known.vel[there] = measured.pos[row], measured.vel[row]
            known.stamp[there] = measured.stamp[row]


@lru_cache(maxsize=KNOWN_NAMES)
def _others(names: Names, swarm: Names) -> Names:
    """Return the names that are not of the swarm."""
    own = set(swarm)
    return tuple(name for name in names if name not in own)
