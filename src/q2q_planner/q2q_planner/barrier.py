"""Turn accelerations so that pairs approach a zone no faster than they can stop: a control barrier.

For a pair with signed distance h to the zone and outward normal n the relative acceleration must satisfy

    n.(a_i - a_j) >= -k_1 h' - k_0 h - (curvature),    h' = n.(v_i - v_j)

(an exponential control barrier function, Nguyen and Sreenath, 2016; pairwise as Wang, Ames and Egerstedt,
Safety barrier certificates for collisions-free multirobot systems, 2017). What is missing is added along n,
half to each vehicle of the swarm, all to one that meets a stranger; SWEEPS of Gauss-Seidel settle crowds.
Around the cylinder's side the rim itself turns, which the curvature term (tangential speed)^2 / radius
credits.

Where the references want to be on each other's far side, a push across n leads around: to the side where
the reference lies, and to the right where it lies straight behind. That breaks the symmetric tie.
"""

from collections.abc import Callable

import numba
import numpy as np
from numpy.typing import NDArray

from q2q_model.signals import Array

SWEEPS = 4
TIE = 0.02
"""A reference within this of straight behind the other is straight behind [m]."""

Rows = NDArray[np.intp]
States = tuple[Array, Array, Array]
"""pos (n, 3), vel (n, 3) and reference position (n, 3); strangers' reference is where they are."""


def _push_apart(
    acc: Array,
    states: States,
    pairs: tuple[Rows, Rows],
    wide: Array,
    law: tuple[int, float, float, float, float, float],
) -> Array:
    """Add to acc (n, 3), in place, what the barriers ask; return which vehicles were pushed, (n,).

    Args:
        acc: wanted accelerations [m/s^2].
        states: of vehicles and strangers.
        pairs: rows i and j of each pair.
        wide: distance from the zone aimed at for each pair [m], and its growth [m/s], (pairs, 2).
        law: how many rows are of the swarm, eps [m], d [m], k_1 [1/s], k_0 [1/s^2], share that leads around.
    """
    pos, vel, ref = states
    own, eps, d, k_1, k_0, around = law
    pushed = np.zeros(acc.shape[0], np.bool_)
    for _ in range(SWEEPS):
        for row in range(pairs[0].size):
            i, j = pairs[0][row], pairs[1][row]
            rel, speed = pos[i] - pos[j], vel[i] - vel[j]
            across = np.sqrt(rel[0] * rel[0] + rel[1] * rel[1])
            side, cap = across - eps, abs(rel[2]) - d
            flat_x, flat_y = (rel[0] / across, rel[1] / across) if across > 1e-9 else (1.0, 0.0)
            up = 1.0 if rel[2] >= 0.0 else -1.0
            if side > 0.0 and cap > 0.0:
                h = np.sqrt(side * side + cap * cap)
                n_flat, n_up = side / h, up * cap / h
            elif side >= cap:
                h, n_flat, n_up = side, 1.0, 0.0
            else:
                h, n_flat, n_up = cap, 0.0, up
            rate = n_flat * (flat_x * speed[0] + flat_y * speed[1]) + n_up * speed[2]
            along = flat_x * speed[1] - flat_y * speed[0]
            wanted = acc[i] - acc[j]
            given = n_flat * (flat_x * wanted[0] + flat_y * wanted[1]) + n_up * wanted[2]
            turning = n_flat * along * along / max(across, 1e-3)
            h -= wide[row, 0]
            rate -= wide[row, 1]
            need = -k_1 * rate - k_0 * h - turning - given
            if need <= 0.0:
                continue
            goal = ref[i] - ref[j]
            behind = -(goal[0] * flat_x + goal[1] * flat_y)
            aside = goal[1] * flat_x - goal[0] * flat_y
            lead = n_flat * around * need * min(1.0, max(0.0, behind / (eps + wide[row, 0])))
            lead *= -1.0 if aside < -TIE else 1.0
            push_x = need * n_flat * flat_x - lead * flat_y
            push_y = need * n_flat * flat_y + lead * flat_x
            both = i < own and j < own
            for vehicle, sign in ((i, 1.0), (j, -1.0)):
                if vehicle < own:
                    share = 0.5 * sign if both else sign
                    acc[vehicle, 0] += share * push_x
                    acc[vehicle, 1] += share * push_y
                    acc[vehicle, 2] += share * need * n_up
                    pushed[vehicle] = True
    return pushed


push_apart: Callable[
    [Array, States, tuple[Rows, Rows], Array, tuple[int, float, float, float, float, float]],
    NDArray[np.bool_],
] = numba.njit(cache=True)(_push_apart)
push_apart_plain = _push_apart
