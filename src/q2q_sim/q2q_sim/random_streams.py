"""Independent random stream for each source of randomness in a flight.

The seed names the flight, the purpose ("vicon noise", "radio loss") names the stream: switching one source
off, or drawing more from it, leaves all others unchanged. Source: numpy's SeedSequence, spawned by name.
"""

from collections.abc import Callable
from zlib import crc32

import numpy as np

from q2q_model.signals.values import Array

AHEAD = 32
"""Ticks drawn at a time: enough that their calls cost little, few enough for the tick that draws."""


def stream(seed: int, purpose: str) -> np.random.Generator:
    """Return the generator for `purpose` in the flight with this `seed` (0 or above)."""
    return np.random.default_rng(np.random.SeedSequence([seed, crc32(purpose.encode())]))


class DrawnAhead:
    """Random numbers of successive ticks, drawn for AHEAD ticks in one call: those of a call in each tick."""

    def __init__(self, draw: Callable[[tuple[int, ...]], Array], shape: tuple[int, ...]) -> None:
        """Draw arrays of a shape by a method of a generator that serves nothing else."""
        self._draw, self._shape = draw, (AHEAD, *shape)
        self._drawn, self._used = np.empty(0), AHEAD

    def next(self) -> Array:
        """Return the numbers of the next tick, of the shape given at the start."""
        if self._used == AHEAD:
            self._drawn, self._used = self._draw(self._shape), 0
        self._used += 1
        row: Array = self._drawn[self._used - 1]
        return row
