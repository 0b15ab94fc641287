"""Let things begin at random and last a while: dropouts, swaps, flips.

Beginnings are a Poisson process a row (rate lambda): in a tick of dt one begins with probability
1 - exp(-lambda dt). Each lasts a time drawn evenly between two bounds, at least one tick; while one lasts,
no other begins in its row.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Frequency:
    """Rate and duration of an event."""

    rate: float
    """Beginnings a second and row [1/s]."""
    shortest: float = 0.0
    """[s]"""
    longest: float = 0.0
    """[s]"""


class Episodes:
    """Rows that are in an episode now."""

    def __init__(self, frequency: Frequency, rows: int, tick: float, rng: np.random.Generator) -> None:
        """Take the tick [s] and a stream of its own."""
        chance = -math.expm1(-frequency.rate * tick)
        self._numbers = chance, frequency.shortest, frequency.longest - frequency.shortest, tick
        self._rng = rng
        self._left = np.zeros(rows, dtype=np.int64)

    def step(self) -> tuple[Mask, Mask]:
        """Move one tick on; return which rows are in an episode and which begin one, (rows,) each."""
        n = len(self._left)
        draws, acting, begins = self._rng.random((2, n)), np.empty(n, np.bool_), np.empty(n, np.bool_)
        move_on(self._left, draws, self._numbers, acting, begins)
        return acting, begins


def _move_on(
    left: NDArray[np.int64],
    draws: Array,
    numbers: tuple[float, float, float, float],
    acting: Mask,
    begins: Mask,
) -> None:
    chance, shortest, spread, tick = numbers
    for i in range(left.size):
        if left[i] > 0:
            left[i] -= 1
        begins[i] = left[i] == 0 and draws[0, i] < chance
        if begins[i]:
            left[i] = max(round((shortest + spread * draws[1, i]) / tick), 1)
        acting[i] = left[i] > 0


move_on = compiled(_move_on)
"""Count down `left` [ticks] (n,) and let episodes begin, writing who is in one and who begins one, (n,):
(left, draws (2, n), (chance a tick, shortest, longest minus shortest, tick [s]), acting, begins)."""
