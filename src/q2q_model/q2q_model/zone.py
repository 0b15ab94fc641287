"""Describe where a draft harms: the set I(eps, d) of section 3.1 and its signed distance.

I(eps, d) = { dr : dx^2 + dy^2 <= eps^2, |dz| <= d }. A zone is symmetric: rel_pos and -rel_pos are both
in it or both out.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from q2q_model.signals import Array


class Zone(Protocol):
    """Measure how far a relative position is from the harmful set."""

    def signed_distance(self, rel_pos: Array) -> Array:
        """Return the distance to the set's boundary [m], (...,), negative inside, of rel_pos (..., 3)."""


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Hold the paper's zone I(eps, d)."""

    eps: float = 0.1
    """Radius [m]; section 3.1: the vehicles' discs do not overlap beyond 92 mm."""
    d: float = 1.1
    """Half height [m]; section 3.1, from the decay of dev."""

    def signed_distance(self, rel_pos: Array) -> Array:
        """Return the distance to the cylinder's surface [m], (...,), negative inside."""
        side = np.hypot(rel_pos[..., 0], rel_pos[..., 1]) - self.eps
        cap = np.abs(rel_pos[..., 2]) - self.d
        outside = np.hypot(np.maximum(side, 0.0), np.maximum(cap, 0.0))
        return np.asarray(np.where((side < 0.0) & (cap < 0.0), np.maximum(side, cap), outside))
