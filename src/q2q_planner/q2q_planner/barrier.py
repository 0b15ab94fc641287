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

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals import Array

SWEEPS = 4
ON_AXIS = 1e-9
"""Nearer to the axis than this, a direction across is made up [m]."""
TIE = 0.02
"""A reference within this of straight behind the other is straight behind [m]."""

Rows = NDArray[np.intp]
States = tuple[Array, Array, Array]
"""pos (n, 3), vel (n, 3) and reference position (n, 3); strangers' reference is where they are."""


Face = tuple[float, float, float, float, float, float]


def _nearest_face(rel: Array, eps: float, d: float) -> Face:
    """Return distance to I(eps, d), its direction (flat_x, flat_y), normal (n_flat, n_up), and dxy."""
    across = np.sqrt(rel[0] * rel[0] + rel[1] * rel[1])
    side, cap = across - eps, abs(rel[2]) - d
    flat_x, flat_y = (rel[0] / across, rel[1] / across) if across > ON_AXIS else (1.0, 0.0)
    up = 1.0 if rel[2] >= 0.0 else -1.0
    if side > 0.0 and cap > 0.0:
        h = np.sqrt(side * side + cap * cap)
        return h, flat_x, flat_y, side / h, up * cap / h, across
    if side >= cap:
        return side, flat_x, flat_y, 1.0, 0.0, across
    return cap, flat_x, flat_y, 0.0, up, across


_compiled_face: Callable[[Array, float, float], Face] = compiled(_nearest_face)


def _push_apart(
    acc: Array,
    states: States,
    pairs: tuple[Rows, Rows],
    wide: Array,
    law: tuple[int, float, float, float, float, float],
) -> NDArray[np.bool_]:
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
    for turn in range(SWEEPS * pairs[0].size):
        row = turn % pairs[0].size
        i, j = pairs[0][row], pairs[1][row]
        speed, wanted, goal = vel[i] - vel[j], acc[i] - acc[j], ref[i] - ref[j]
        h, flat_x, flat_y, n_flat, n_up, across = _compiled_face(pos[i] - pos[j], eps, d)
        rate = n_flat * (flat_x * speed[0] + flat_y * speed[1]) + n_up * speed[2] - wide[row, 1]
        given = n_flat * (flat_x * wanted[0] + flat_y * wanted[1]) + n_up * wanted[2]
        along = flat_x * speed[1] - flat_y * speed[0]
        turning = n_flat * along * along / max(across, eps)
        need = -k_1 * rate - k_0 * (h - wide[row, 0]) - turning - given
        if not need > 0.0:
            continue
        behind = -(goal[0] * flat_x + goal[1] * flat_y)
        aside = goal[1] * flat_x - goal[0] * flat_y
        lead = n_flat * around * need * min(1.0, max(0.0, behind / (eps + wide[row, 0])))
        lead *= -1.0 if aside < -TIE else 1.0
        x = need * n_flat * flat_x - lead * flat_y
        y = need * n_flat * flat_y + lead * flat_x
        share = 0.5 if j < own else 1.0
        for vehicle, sign in ((i, share), (j, -share)):
            if vehicle < own:
                acc[vehicle, 0] += sign * x
                acc[vehicle, 1] += sign * y
                acc[vehicle, 2] += sign * need * n_up
                pushed[vehicle] = True
    return pushed


push_apart: Callable[
    [Array, States, tuple[Rows, Rows], Array, tuple[int, float, float, float, float, float]],
    NDArray[np.bool_],
] = compiled(_push_apart)
push_apart_plain = _push_apart
