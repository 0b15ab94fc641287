"""Remember what was last heard of vehicles: neighbours that fly by others' setpoints, and our own.

A message of age A says where a vehicle was, not where it is. Memory keeps the newest word on each vehicle,
so that one which vanishes from the state goes on as one whose word grows old, until it is forgotten.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array, Names, SwarmState


@dataclass(frozen=True, slots=True)
class Word:
    """Newest state of some vehicles."""

    names: Names
    pos: Array
    """Where they were [m], (n, 3)."""
    vel: Array
    """How they moved [m/s], (n, 3)."""
    age: Array
    """How long ago [s], (n,)."""


class LastKnownStates:
    """Last known state of every vehicle."""

    def __init__(self) -> None:
        """Start with no word."""
        self._seen: dict[str, tuple[Array, Array, float]] = {}

    def reset(self) -> None:
        """Forget everyone."""
        self._seen.clear()

    def hear(self, state: SwarmState) -> None:
        """Take in a state; rows with NaN, or older than what is known, say nothing new."""
        stamps = state.t - state.age
        sound = np.isfinite(state.pos).all(1) & np.isfinite(state.vel).all(1) & np.isfinite(stamps)
        for row in np.flatnonzero(sound):
            name, stamp = state.names[row], float(stamps[row])
            known = self._seen.get(name)
            if known is None or stamp > known[2]:
                self._seen[name] = (state.pos[row], state.vel[row], stamp)

    def strangers(self, swarm: Names, t: float, forget: float) -> Word:
        """Return the word on all vehicles that are not of the swarm and were heard of within `forget` [s]."""
        for name in [name for name, (_, _, stamp) in self._seen.items() if t - stamp > forget]:
            del self._seen[name]
        own = set(swarm)
        return self._word(tuple(name for name in self._seen if name not in own), t)

    def of(self, names: Names, t: float) -> Word:
        """Return the word on these vehicles; where there is none, NaN and infinite age."""
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
