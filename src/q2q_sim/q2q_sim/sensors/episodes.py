"""Random episodes of a sensor: dropouts, swaps, flips.

Onsets are a Poisson process for each row (rate lambda): in a tick of dt one occurs with probability
1 - exp(-lambda dt). The duration is uniform between two bounds, at least one tick; during an episode no
other starts in the same row. Nothing in a flight acts on them, so AHEAD ticks are drawn at a time.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask
from q2q_sim.random_streams import AHEAD


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
        """Start without active episodes; `tick` is the sample time [s], `rng` its own stream."""
        chance = -math.expm1(-frequency.rate * tick)
        self._numbers = chance, frequency.shortest, frequency.longest - frequency.shortest, tick
        self._rng = rng
        self._left = np.zeros(rows, dtype=np.int64)
        self._tick = 0
        self._draw()

    def step(self) -> tuple[Mask, Mask] | None:
        """Advance one tick; return which rows are in an episode and which start one, (rows,) each.

        None if no row is in one, as in most ticks.
        """
        if self._tick == AHEAD:
            self._draw()
            self._tick = 0
        k, self._tick = self._tick, self._tick + 1
        return (self._acting[k], self._begins[k]) if self._some[k] else None

    def _draw(self) -> None:
        """Draw AHEAD ticks, the same numbers as one tick at a time."""
        rows = len(self._left)
        draws = self._rng.random((AHEAD, 2, rows))
        self._acting, self._begins = np.empty((AHEAD, rows), np.bool_), np.empty((AHEAD, rows), np.bool_)
        advance_episodes(self._left, draws, self._numbers, self._acting, self._begins)
        self._some: list[bool] = np.asarray(self._acting.any(axis=1)).tolist()


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
        draws: uniform deviates of each tick, (ticks, 2, n).
        numbers: probability of an onset, shortest duration, longest minus shortest, tick [s].
        acting: written: which rows are in an episode, (ticks, n).
        begins: written: which start one, (ticks, n).
    """
    chance, shortest, spread, tick = numbers
    for k in range(len(draws)):
        for i in range(left.size):
            if left[i] > 0:
                left[i] -= 1
            begins[k, i] = left[i] == 0 and draws[k, 0, i] < chance
            if begins[k, i]:
                left[i] = max(round((shortest + spread * draws[k, 1, i]) / tick), 1)
            acting[k, i] = left[i] > 0
