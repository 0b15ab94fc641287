"""Lower bound of the heights to which vehicles are led away from their references.

A pair above each other is parted vertically, which would lead the lower vehicle into the floor. A vehicle
that is not on its reference is therefore led no lower than

    b = min(z_min, z_ref)

so take-offs and landings by a reference remain possible. Two parts keep it there. A control barrier bounds
the vertical acceleration, with the poles of the approach to a zone; a descending reference below z_min takes
the bound along (v_b, a_b are its velocity and acceleration, else 0):

    z'' >= a_b - k_1 (z' - v_b) - k_0 max(z - b, 0)

And a new motion that would come to rest below b is not flown: the rest of the old one is, which does not. As
a vehicle may be low when it leaves a diving reference, or is measured low, a motion is too low only if it
rests lower than the old one, and than the reference would if it stopped now.

| symbol | name | meaning [unit] |
|---|---|---|
| z_min | law.lowest | height_min of SafeReplannerParams [m] |
| k_1, k_0 | law.k_1, law.k_0 | gains of the barrier [1/s, 1/s^2] |
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array
from q2q_planner.online.safe.motion.committed_motion import MotionRows
from q2q_planner.online.safe.motion.followed_reference import ReferenceRows
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions
from q2q_planner.online.safe.stopping.rest_height import rest_height

ROUNDING = 1e-9
"""Of a height that is computed in several ways [m]."""


class HeightLaw(NamedTuple):
    """Bound of heights, and how it is approached."""

    lowest: float
    """[m]."""
    k_1: float
    """[1/s]."""
    k_0: float
    """[1/s^2]."""
    acc: float
    """Largest acceleration [m/s^2]."""


class Candidates(NamedTuple):
    """Motions of n vehicles that a tick compares."""

    new: Motions
    old: Motions
    """Rest of the motions of the tick before."""
    reference: Motions
    """A stop from the reference."""


@compiled
def least_climbs(rows: MotionRows, reference: ReferenceRows, law: HeightLaw) -> Array:
    """Return the least vertical accelerations that keep vehicles above their bounds, (n,) [m/s^2]."""
    least = np.empty(rows.hold.size)
    for row in range(least.size):
        z, rate, asked = rows.pos[row, 2], rows.vel[row, 2], reference.pos[row, 2]
        least[row] = -law.k_0 * max(z - min(law.lowest, asked), 0.0)
        if asked < law.lowest and reference.vel[row, 2] < 0.0:
            rate -= reference.vel[row, 2]
            least[row] += reference.acc[row, 2]
        least[row] = min(least[row] - law.k_1 * rate, law.acc)
    return least


@compiled
def candidates_of(
    rows: MotionRows, reference: ReferenceRows, new: tuple[Array, Array], hold: float
) -> Candidates:
    """Return what a tick compares; `new` are accelerations and jerks of new motions, held for `hold` [s]."""
    acc, jerk = new
    growth, held = np.zeros((rows.hold.size, 2)), np.full(rows.hold.size, hold)
    return Candidates(
        Motions(rows.pos, rows.vel, acc, held, growth, jerk),
        Motions(rows.pos, rows.vel, rows.acc, rows.hold, growth, rows.jerk),
        Motions(reference.pos, reference.vel, reference.acc, held, growth, np.zeros_like(jerk)),
    )


@compiled(**HOT)
def is_too_low(candidates: Candidates, row: int, lowest: float, law: BrakingLaw) -> bool:
    """Return whether the new motion of a row rests below the bound, its old motion and its reference."""
    low = rest_height(candidates.new, row, law) + ROUNDING
    if low >= min(lowest, candidates.reference.pos[row, 2]):
        return False
    if low >= rest_height(candidates.old, row, law):
        return False
    return low < rest_height(candidates.reference, row, law)
