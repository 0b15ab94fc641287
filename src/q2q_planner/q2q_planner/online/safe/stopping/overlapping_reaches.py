"""Pairs whose motions might meet before both rest: their reaches overlap, so each pair needs a proof.

The reach of a motion is how far it may move until all rest, with its growth; it covers the new motion of a
vehicle and its old one.
"""

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Rows
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions
from q2q_planner.online.safe.stopping.broad_phase import Pairs
from q2q_planner.online.safe.stopping.jerk_limited import StoppingMotions, rest_time, stop_reach


@compiled
def near_pairs(new: StoppingMotions, old: StoppingMotions, pairs: Pairs, law: BrakingLaw) -> Rows:
    """Return the rows of `pairs` whose reaches overlap, (k,): the others are proven.

    `new` and `old` are the motions of all vehicles, row by row.
    """
    reaches = _reaches(new, old, law)
    pos = new.motions.pos
    found = np.empty(pairs.i.size, np.intp)
    count = 0
    for row in range(pairs.i.size):
        i, j = pairs.i[row], pairs.j[row]
        x, y = pos[i, 0] - pos[j, 0], pos[i, 1] - pos[j, 1]
        far = reaches[i] + reaches[j]
        if np.sqrt(x * x + y * y) - law.eps > far or abs(pos[i, 2] - pos[j, 2]) - law.d > far:
            continue
        found[count] = row
        count += 1
    return found[:count]


@compiled
def _reaches(new: StoppingMotions, old: StoppingMotions, law: BrakingLaw) -> Array:
    """Return how far each row may move, with growth, before all rest [m], (rows,).

    A pair's growth continues until both rest, which the longest stopping time of all bounds.
    """
    if law.jerk > 0.0:
        last = 0.0
        for row in range(new.motions.hold.size):
            last = max(last, rest_time(new, row), rest_time(old, row))
        reach: Array = np.maximum(stop_reach(new, law, last), stop_reach(old, law, last))
        return reach
    longest = max(_stopping_time(new.motions, law.brake), _stopping_time(old.motions, law.brake))
    rate = new.motions.growth[:, 1].max()
    late = rate * (longest + 2.0 * rate / law.brake)
    first, rest = _braking_reach(new.motions, law.brake), _braking_reach(old.motions, law.brake)
    reaches: Array = np.maximum(first, rest) + late
    return reaches


@compiled
def _braking_reach(motions: Motions, brake: float) -> Array:
    """Return the stopping distance of each row with its growth until rest [m], (rows,)."""
    reach = np.empty(motions.hold.size)
    rates = motions.growth[:, 1].max()
    for row in range(motions.hold.size):
        hold, growth = motions.hold[row], motions.growth[row]
        speed = np.sqrt((motions.vel[row] ** 2).sum()) + np.sqrt((motions.acc[row] ** 2).sum()) * hold
        rest = speed / brake + hold
        reach[row] = speed * (hold + 0.5 * speed / brake) + growth[0]
        reach[row] += growth[1] * (rest + 2.0 * rates / brake)
    return reach


@compiled
def _stopping_time(motions: Motions, brake: float) -> float:
    """Return the longest time until a row rests [s]."""
    longest = 0.0
    for row in range(motions.hold.size):
        hold = motions.hold[row]
        speed = np.sqrt((motions.vel[row] ** 2).sum()) + np.sqrt((motions.acc[row] ** 2).sum()) * hold
        longest = max(longest, speed / brake + hold)
    return longest
