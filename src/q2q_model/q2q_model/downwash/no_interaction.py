"""Interaction model without downwash."""

from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.interaction_model import PairMotion, Reach
from q2q_model.signals.values import Array


@dataclass(frozen=True, slots=True)
class NoInteraction:
    """Model without interaction."""

    @property
    def reach(self) -> Reach:
        """Return a reach of zero: no pair is evaluated."""
        return Reach(horizontal=0.0, vertical=0.0)

    @property
    def max_delay(self) -> float:
        """Return zero [s]."""
        return 0.0

    def delay(self, rel_pos: Array) -> Array:
        """Return zeros [s], (...,)."""
        return np.zeros(rel_pos.shape[:-1])

    def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:  # noqa: ARG002
        """Return zeros [m/s^2], (..., 3)."""
        return np.zeros(rel_pos.shape)

    def deviation(self, rel_pos: Array, motion: PairMotion) -> Array:  # noqa: ARG002
        """Return NaN [m/s^2], (..., 3): unknown."""
        return np.full(rel_pos.shape, np.nan)
