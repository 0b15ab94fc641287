"""What is wrong with the poses of a frame, whatever the tracks are."""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.estimation.attitude.attitude_steps import UNIT_TOLERANCE
from q2q_model.signals.values import Array, Mask


class PoseFaults(NamedTuple):
    """Vehicles by what is wrong with their poses, (n,) each."""

    outside: Mask
    """Positions further from the origin, along an axis, than is accepted."""
    not_unit: Mask
    """Finite quaternions of another length than 1, to UNIT_TOLERANCE."""
    upside_down: Mask
    """Quaternions of unit length whose body z does not point up."""
    missing: Mask
    """No finite position."""


@compiled
def pose_faults(poses: Array, pos_max: float) -> PoseFaults:
    """Return the faults of poses x y z [m], x y z w, (n, 7); accepted positions are within pos_max [m]."""
    outside, not_unit, upside_down, missing = np.zeros((4, len(poses)), np.bool_)
    found = PoseFaults(outside, not_unit, upside_down, missing)
    for i in range(len(poses)):
        x, y, z = abs(poses[i, 0]), abs(poses[i, 1]), abs(poses[i, 2])
        found.outside[i] = x > pos_max or y > pos_max or z > pos_max
        found.missing[i] = not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z))
        a, b, c, d = poses[i, 3], poses[i, 4], poses[i, 5], poses[i, 6]
        length = math.sqrt(a * a + b * b + c * c + d * d)
        finite = math.isfinite(a) and math.isfinite(b) and math.isfinite(c) and math.isfinite(d)
        found.not_unit[i] = finite and not abs(length - 1.0) <= UNIT_TOLERANCE
        found.upside_down[i] = finite and not found.not_unit[i] and a * a + b * b >= c * c + d * d
    return found
