"""Last known state of every vehicle: those of the swarm and external ones.

A vehicle that vanishes from the state keeps its last known state, with growing age, until it is forgotten.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array, Names, SwarmState


@dataclass(frozen=True, slots=True)
class Word:
    """Last known states of some vehicles."""

    names: Names
    pos: Array
    """Measured position [m], (n, 3)."""
    vel: Array
    """Measured velocity [m/s], (n, 3)."""
    age: Array
    """Age of the measurement [s], (n,)."""


class LastKnownStates:
    """Memory of the last known states."""

    def __init__(self) -> None:
        self._seen: dict[str, tuple[Array, Array, float]] = {}

    def reset(self) -> None:
        """Forget all vehicles."""
        self._seen.clear()

    def hear(self, state: SwarmState) -> None:
        """Store a state; rows with NaN, or not newer than the stored one, are ignored."""
        stamps = state.t - state.age
        sound = np.isfinite(state.pos).all(1) & np.isfinite(state.vel).all(1) & np.isfinite(stamps)
        for row in np.flatnonzero(sound):
            name, stamp = state.names[row], float(stamps[row])
            known = self._seen.get(name)
            if known is None or stamp > known[2]:
                self._seen[name] = (state.pos[row], state.vel[row], stamp)

    def strangers(self, swarm: Names, t: float, forget: float) -> Word:
        """Return the states of all vehicles outside the swarm that are younger than `forget` [s]."""
        for name in [name for name, (_, _, stamp) in self._seen.items() if t - stamp > forget]:
            del self._seen[name]
        own = set(swarm)
        return self._word(tuple(name for name in self._seen if name not in own), t)

    def of(self, names: Names, t: float) -> Word:
        """Return the states of these vehicles; NaN with infinite age for an unknown one."""
        return self._word(names, t)

    def _word(self, names: Names, t: float) -> Word:
        silent = np.full(3, np.nan), np.full(3, np.nan), -np.inf
        rows = [self._seen.get(name, silent) for name in names]
        return Word(
            names,
            np.array([row[0] for row in rows]).reshape(-1, 3),
            np.array([row[1] for row in rows]).reshape(-1, 3),
            np.maximum(t - np.array([row[2] for row in rows]), 0.0),
        )
