"""Let things begin at random and last a while: dropouts, swaps, flips.

Beginnings are a Poisson process a row (rate lambda): in a tick of dt one begins with probability
1 - exp(-lambda dt). Each lasts a time drawn evenly between two bounds, at least one tick; while one lasts,
no other begins in its row.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Frequency:
    """Say how often something happens, and how long it lasts."""

    rate: float
    """Beginnings a second and row [1/s]."""
    shortest: float = 0.0
    """[s]"""
    longest: float = 0.0
    """[s]"""


class Episodes:
    """Hold which rows are in an episode now."""

    def __init__(self, frequency: Frequency, rows: int, tick: float, rng: np.random.Generator) -> None:
        """Take the tick [s] and a stream of its own."""
        self._frequency = frequency
        self._chance = -math.expm1(-frequency.rate * tick)
        self._tick = tick
        self._rng = rng
        self._left = np.zeros(rows, dtype=np.int64)

    def step(self) -> tuple[Mask, Mask]:
        """Move one tick on; return which rows are in an episode and which begin one, (rows,) each."""
        self._left -= self._left > 0
        chance, length = self._rng.random((2, len(self._left)))
        begins = (self._left == 0) & (chance < self._chance)
        spread = self._frequency.longest - self._frequency.shortest
        lasts = np.round((self._frequency.shortest + spread * length) / self._tick).astype(np.int64)
        self._left[begins] = np.maximum(lasts[begins], 1)
        return self._left > 0, begins
