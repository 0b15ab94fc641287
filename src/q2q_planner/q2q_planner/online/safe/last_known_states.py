"""Last known state of every vehicle: those of the swarm and external ones.

A vehicle that vanishes from the state keeps its last known state, with growing age, until it is forgotten.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array, Names, SwarmState


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


class _KnownState(NamedTuple):
    """Last known state of one vehicle."""

    pos: Array
    vel: Array
    stamp: float


class LastKnownStates:
    """Memory of the last known states."""

    def __init__(self) -> None:
        self._known: dict[str, _KnownState] = {}

    def reset(self) -> None:
        """Forget all vehicles."""
        self._known.clear()

    def update(self, state: SwarmState) -> None:
        """Store a state; rows with NaN, or not newer than the stored one, are ignored."""
        stamps = state.t - state.age
        finite = np.isfinite(state.pos).all(1) & np.isfinite(state.vel).all(1) & np.isfinite(stamps)
        for row in np.flatnonzero(finite):
            name, stamp = state.names[row], float(stamps[row])
            known = self._known.get(name)
            if known is None or stamp > known.stamp:
                self._known[name] = _KnownState(state.pos[row], state.vel[row], stamp)

    def external(self, swarm: Names, t: float, forget: float) -> KnownStates:
        """Return the states of all vehicles outside the swarm that are younger than `forget` [s]."""
        for name in [name for name, known in self._known.items() if t - known.stamp > forget]:
            del self._known[name]
        own = set(swarm)
        return self.of(tuple(name for name in self._known if name not in own), t)

    def of(self, names: Names, t: float) -> KnownStates:
        """Return the states of these vehicles; NaN with infinite age for an unknown one."""
        unknown = _KnownState(np.full(3, np.nan), np.full(3, np.nan), -np.inf)
        rows = [self._known.get(name, unknown) for name in names]
        return KnownStates(
            names,
            np.array([row.pos for row in rows]).reshape(-1, 3),
            np.array([row.vel for row in rows]).reshape(-1, 3),
            np.maximum(t - np.array([row.stamp for row in rows]), 0.0),
        )
