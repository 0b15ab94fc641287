"""Downwash zones with signed distances: the set I(eps, d) of section 3.1, and a smooth ellipsoid.

I(eps, d) = { dr : dx^2 + dy^2 <= eps^2, |dz| <= d }. Zones are symmetric in the sign of rel_pos. `Ellipsoid`
is smooth, as successive convexification requires; the level set of a learned downwash model is in
q2q_model.downwash.level_set.
"""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from q2q_model.signals.values import Array

LARGEST = 100.0
"""Bound of eps and d [m]: beyond any flight room."""


class Zone(Protocol):
    """Set of relative positions with harmful downwash, and its distance function."""

    def signed_distance(self, rel_pos: Array) -> Array:
        """Return the distance to the set's boundary [m], (...,), negative inside, of rel_pos (..., 3)."""


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Zone I(eps, d) of the paper."""

    eps: float = 0.1
    """Radius [m]; section 3.1: the rotor discs do not overlap beyond 92 mm."""
    d: float = 1.1
    """Half height [m]; section 3.1, from the decay of dev."""

    def __post_init__(self) -> None:
        """Check the size."""
        _check_size(self)

    def signed_distance(self, rel_pos: Array) -> Array:
        """Return the distance to the cylinder's surface [m], (...,), negative inside."""
        side = np.hypot(rel_pos[..., 0], rel_pos[..., 1]) - self.eps
        cap = np.abs(rel_pos[..., 2]) - self.d
        outside = np.hypot(np.maximum(side, 0.0), np.maximum(cap, 0.0))
        return np.asarray(np.where((side < 0.0) & (cap < 0.0), np.maximum(side, cap), outside))


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """Spheroid about the vertical axis: (dx^2 + dy^2) / eps^2 + dz^2 / d^2 <= 1."""

    eps: float
    """Horizontal semi-axis [m]."""
    d: float
    """Vertical semi-axis [m]."""

    def __post_init__(self) -> None:
        """Check the semi-axes."""
        _check_size(self)

    @classmethod
    def around(cls, cylinder: Cylinder) -> "Ellipsoid":
        """Return the smallest spheroid that encloses a cylinder.

        Its volume ~ a^2 c is minimal under eps^2/a^2 + d^2/c^2 = 1 at a = eps sqrt(3/2), c = d sqrt(3).
        """
        return cls(eps=cylinder.eps * math.sqrt(1.5), d=cylinder.d * math.sqrt(3.0))

    def signed_distance(self, rel_pos: Array) -> Array:
        """Return the distance to the spheroid's surface [m], (...,), negative inside."""
        across, along = np.hypot(rel_pos[..., 0], rel_pos[..., 1]), np.abs(rel_pos[..., 2])
        nearest_across, nearest_along = self._nearest(across, along)
        distance = np.hypot(across - nearest_across, along - nearest_along)
        inside = (across / self.eps) ** 2 + (along / self.d) ** 2 < 1.0
        return np.asarray(np.where(inside, -distance, distance))

    def _nearest(self, across: Array, along: Array) -> tuple[Array, Array]:
        """Return the nearest point of the ellipse in the first quadrant.

        It is (a^2 p / (t + a^2), c^2 q / (t + c^2)) for the largest root t of
        (a p / (t + a^2))^2 + (c q / (t + c^2))^2 = 1 (Eberly, Distance from a Point to an Ellipse, 2013).
        A lower bound keeps p and q off the axes, where the nearest point is not unique.
        """
        a, c = self.eps, self.d
        p, q = np.maximum(across, 1e-9 * a), np.maximum(along, 1e-9 * c)
        low, high = np.maximum(a * p - a * a, c * q - c * c), np.hypot(a * p, c * q)
        for _ in range(60):  # bisection to 2^-60 of the bracket
            t = 0.5 * (low + high)
            beyond = (a * p / (t + a * a)) ** 2 + (c * q / (t + c * c)) ** 2 > 1.0
            low, high = np.where(beyond, t, low), np.where(beyond, high, t)
        return a * a * p / (high + a * a), c * c * q / (high + c * c)


def _check_size(zone: Cylinder | Ellipsoid) -> None:
    """Raise ValueError for a zone without extent, or one larger than any room."""
    for name, value in (("eps", zone.eps), ("d", zone.d)):
        if not 0.0 < value < LARGEST:
            raise ValueError(
                f"{type(zone).__name__}.{name} = {value}; must be above 0 and below {LARGEST:g} m"
            )
