"""Random episodes of a sensor: dropouts, swaps, flips.

Onsets are a Poisson process for each row (rate lambda): in a tick of dt one occurs with probability
1 - exp(-lambda dt). The duration is uniform between two bounds, at least one tick; during an episode no
other starts in the same row.
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
    """Rate and duration of a kind of episode."""

    rate: float
    """Onsets per second in each row [1/s]."""
    shortest: float = 0.0
    """[s]"""
    longest: float = 0.0
    """[s]"""


class Episodes:
    """Active episodes of each row."""

    def __init__(self, frequency: Frequency, rows: int, tick: float, rng: np.random.Generator) -> None:
        """Start without active episodes; `tick` is the sample time [s], `random` its own stream."""
        chance = -math.expm1(-frequency.rate * tick)
        self._numbers = chance, frequency.shortest, frequency.longest - frequency.shortest, tick
        self._rng = rng
        self._left = np.zeros(rows, dtype=np.int64)

    def step(self) -> tuple[Mask, Mask]:
        """Advance one tick; return which rows are in an episode and which start one, (rows,) each."""
        n = len(self._left)
        draws, acting, begins = self._rng.random((2, n)), np.empty(n, np.bool_), np.empty(n, np.bool_)
        advance_episodes(self._left, draws, self._numbers, acting, begins)
        return acting, begins


@compiled
def advance_episodes(
    left: NDArray[np.int64],
    draws: Array,
    numbers: tuple[float, float, float, float],
    acting: Mask,
    begins: Mask,
) -> None:
    """Count down active episodes and start new ones.

    Args:
        left: remaining ticks, (n,).
        draws: uniform deviates, (2, n).
        numbers: probability of an onset, shortest duration, longest minus shortest, tick [s].
        acting: written: which rows are in an episode.
        begins: written: which start one.
    """
    chance, shortest, spread, tick = numbers
    for i in range(left.size):
        if left[i] > 0:
            left[i] -= 1
        begins[i] = left[i] == 0 and draws[0, i] < chance
        if begins[i]:
            left[i] = max(round((shortest + spread * draws[1, i]) / tick), 1)
        acting[i] = left[i] > 0
