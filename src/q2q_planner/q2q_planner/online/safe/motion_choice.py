"""Choice, for every vehicle, of a motion that is proven against the motions of all others.

Every vehicle has a new motion and the rest of its old one. If a pair of new motions fails, one of the two
vehicles returns to its old motion, taking turns, and if that does not suffice, so does the other. Old motions
were proven against each other, so this ends with all pairs proven. They are checked again nevertheless: if
even they fail, which requires a broken condition of the promise, both vehicles are BROKEN and fly the new
motion, which at least pushes them apart.

Rows from `own` on are external vehicles, whose motion cannot be chosen. A new motion is proven against every
motion that an external vehicle may fly. An old one was; once the two are `proven`, it is checked only against
the motion that an external vehicle under this law certainly flies (the rows of `old`).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_planner.online.safe.barrier import Rows
from q2q_planner.online.safe.braking import Motions, compiled_stays_out

OLD, NEW, BROKEN = 0, 1, 2

Choices = NDArray[np.int8]
Proven = NDArray[np.bool_]


def _far_reach(motions: Motions, brake: float) -> Array:
    """Return the stopping distance of each row with its growth until rest [m], (rows,)."""
    _, vel, acc, hold, growth = motions
    reach = np.empty(vel.shape[0])
    rates = growth[:, 1].max()
    for row in range(vel.shape[0]):
        speed = np.sqrt((vel[row] ** 2).sum()) + np.sqrt((acc[row] ** 2).sum()) * hold[row]
        rest = speed / brake + hold[row]
        reach[row] = speed * (hold[row] + 0.5 * speed / brake) + growth[row, 0]
        reach[row] += growth[row, 1] * (rest + 2.0 * rates / brake)
    return reach


_reach_of = compiled(_far_reach)


def _pairs_that_may_meet(
    new: Motions, old: Motions, pairs: tuple[Rows, Rows], law: tuple[float, float, float]
) -> Rows:
    """Return the rows of pairs whose stopping distances overlap, (k,): the others are proven.

    A pair's growth continues until both rest, which the longest stopping time of all bounds.
    """
    eps, d, brake = law
    slow = 0.0
    for motions in (new, old):
        for row in range(motions[1].shape[0]):
            speed = (
                np.sqrt((motions[1][row] ** 2).sum())
                + np.sqrt((motions[2][row] ** 2).sum()) * motions[3][row]
            )
            slow = max(slow, speed / brake + motions[3][row])
    rate = new[4][:, 1].max()
    late = rate * (slow + 2.0 * rate / brake)
    ways = np.maximum(_reach_of(new, brake), _reach_of(old, brake)) + late
    found = np.empty(pairs[0].size, np.intp)
    count = 0
    for row in range(pairs[0].size):
        i, j = pairs[0][row], pairs[1][row]
        x, y = new[0][i, 0] - new[0][j, 0], new[0][i, 1] - new[0][j, 1]
        far = ways[i] + ways[j]
        if np.sqrt(x * x + y * y) - eps > far or abs(new[0][i, 2] - new[0][j, 2]) - d > far:
            continue
        found[count] = row
        count += 1
    return found[:count]


_near = compiled(_pairs_that_may_meet)


def _choose(  # noqa: C901
    new: Motions,
    old: Motions,
    pairs: tuple[Rows, Rows],
    proven: Proven,
    limits: tuple[float, float, float, float, int],
) -> Choices:
    """Return the choice of each row, (rows,).

    Args:
        new: motions offered; strangers: what they may do.
        old: motions going on; strangers: what they surely do.
        pairs: rows i < j, i of the swarm.
        proven: pairs of the swarm (n,) and strangers (m,) proven together before, (n, m); changed in place.
        limits: eps [m], d [m], brake [m/s^2], floor [m], and a number that tells whose turn it is to yield.
    """
    eps, d, brake, floor, turn = limits
    law, own = (eps, d, brake), proven.shape[0]
    acc, hold = new[2].copy(), new[3].copy()
    mixed = (new[0], new[1], acc, hold, new[4])
    choice = np.ones(new[0].shape[0], np.int8)
    near = _near(new, old, pairs, law)
    changed = True
    while changed:
        changed = False
        for row in near:
            i, j = pairs[0][row], pairs[1][row]
            if choice[i] == 0 and ((j < own and choice[j] == 0) or (j >= own and proven[i, j - own])):
                if compiled_stays_out(old, i, j, law, 0.0):
                    continue
            elif compiled_stays_out(mixed, i, j, law, floor):
                continue
            first, second = (i, j) if (i + j + turn) % 2 == 0 or j >= own else (j, i)
            for vehicle in (first, second):
                if vehicle < own and choice[vehicle] == 1:
                    choice[vehicle] = 0
                    acc[vehicle], hold[vehicle] = old[2][vehicle], old[3][vehicle]
                    changed = True
                    break
            else:
                for vehicle in (i, j):
                    if vehicle < own and choice[vehicle] == 0:
                        choice[vehicle] = 2
                        acc[vehicle], hold[vehicle] = new[2][vehicle], new[3][vehicle]
                        changed = True
    for row in range(pairs[0].size):
        i, j = pairs[0][row], pairs[1][row] - own
        if j >= 0 and choice[i] != 2 and not proven[i, j]:
            proven[i, j] = compiled_stays_out(mixed, i, j + own, law, floor)
    return choice


choose_motions: Callable[
    [Motions, Motions, tuple[Rows, Rows], Proven, tuple[float, float, float, float, int]], Choices
] = compiled(_choose)
