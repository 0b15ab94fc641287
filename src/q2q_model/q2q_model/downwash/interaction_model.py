"""Say what an interaction model is: a law for one pair, and how late its push arrives.

eta_i(t) = sum over j of law(r_j(t - tau) - r_i(t), v_j(t - tau), b_j(t - tau), v_i(t)),
tau = delay(r_j(t) - r_i(t)),

with b the body z axis: a rotor throws its air along -b, so a tilted source aims its downwash aside.

i feels, j causes; rel_pos = pos_j - pos_i, so a source above has rel_pos z > 0. Laws act on arrays of
pairs of any batch shape; memory of past states is kept outside, by `StateHistory` online and by the
arrays of a flight offline.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from q2q_model.signals.values import Array


@dataclass(frozen=True, slots=True)
class Reach:
    """Bound where a law acts: beyond it the acceleration is negligible."""

    horizontal: float
    """[m]"""
    vertical: float
    """[m]"""


UP = np.array([0.0, 0.0, 1.0])
"""Body z of a level vehicle."""


@dataclass(frozen=True, slots=True)
class PairMotion:
    """Motion of a pair: the source when its air left it, the exposed vehicle now."""

    source_vel: Array
    """Velocity of j [m/s], world, (..., 3)."""
    source_axis: Array
    """Body z of j, unit length, world, (..., 3)."""
    vel: Array
    """Velocity of i [m/s], world, (..., 3)."""


def at_rest(rel_pos: Array) -> PairMotion:
    """Return level vehicles at rest, a pair for each relative position (..., 3)."""
    still = np.zeros_like(rel_pos)
    return PairMotion(source_vel=still, source_axis=still + UP, vel=still)


class InteractionModel(Protocol):
    """Model of the downwash of one source at one vehicle."""

    @property
    def reach(self) -> Reach:
        """Return how far the downwash acts."""

    @property
    def max_delay(self) -> float:
        """Return the longest transport delay [s]; 0 for a model without one."""

    def delay(self, rel_pos: Array) -> Array:
        """Return the transport delay tau [s], (...,), of the push of a source at rel_pos [m], (..., 3)."""

    def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return eta [m/s^2], world, (..., 3), for retarded rel_pos [m], (..., 3), and motion."""

    def deviation(self, rel_pos: Array, motion: PairMotion) -> Array:
        """Return one standard deviation of the prediction [m/s^2], (..., 3); NaN where unknown."""
