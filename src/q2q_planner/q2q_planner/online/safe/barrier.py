"""Control barrier on accelerations: pairs approach a zone no faster than they can stop.

For a pair with signed distance h to the zone and outward normal n the relative acceleration must satisfy

    n.(a_i - a_j) >= -k_1 h' - k_0 h - (curvature),    h' = n.(v_i - v_j)

(an exponential control barrier function, Nguyen and Sreenath, 2016; pairwise as Wang, Ames and Egerstedt,
Safety barrier certificates for collisions-free multirobot systems, 2017). The violation is corrected along n,
half by each vehicle of the swarm, or all by one that meets an external vehicle; SWEEPS Gauss-Seidel sweeps
resolve several pairs at once. The curvature term (tangential speed)^2 / radius accounts for the rotation of n
along the cylinder's side.

If the references are on opposite sides of each other, a push perpendicular to n leads around: to the side of
the reference, or to the right if it is straight behind, which breaks the symmetric tie.

Downwash disturbs heights and formations hold them, so horizontal pushes are preferred: of all pushes p with
n.p = need, the one that minimises |p_flat|^2 + p_up^2 / w, where w below 1 is the weight of height:
p = need (n_flat, w n_up) / (n_flat^2 + w n_up^2). For vehicles above each other, n_flat = 0, it is vertical.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

SWEEPS = 4
FAR = 6.0
"""Required acceleration below -FAR times the largest wanted one: the pair is too far apart to matter."""
ON_AXIS = 1e-9
"""Horizontal distance below which the direction is taken as x [m]."""
TIE = 0.02
"""Lateral offset below which a reference counts as straight behind the other [m]."""

Rows = NDArray[np.intp]
States = tuple[Array, Array, Array]
"""pos (n, 3), vel (n, 3) and reference position (n, 3); strangers' reference is where they are."""
Law = tuple[int, float, float, float, float, float, float]
"""Rows of the swarm, eps [m], d [m], k_1 [1/s], k_0 [1/s^2], share of a push that leads around, w."""


def _nearest_face(rel_pos: tuple[float, float, float], eps: float, d: float, face: Array) -> float:
    """Write direction (flat_x, flat_y) and normal (n_flat, n_up) of I(eps, d) to `face`; return h."""
    x, y, z = rel_pos
    across = np.sqrt(x * x + y * y)
    side, cap = across - eps, abs(z) - d
    face[0], face[1] = (x / across, y / across) if across > ON_AXIS else (1.0, 0.0)
    up = 1.0 if z >= 0.0 else -1.0
    if side > 0.0 and cap > 0.0:
        h = np.sqrt(side * side + cap * cap)
        face[2], face[3] = side / h, up * cap / h
        return float(h)
    face[2], face[3] = (1.0, 0.0) if side >= cap else (0.0, up)
    return float(max(side, cap))


_face_of = compiled(_nearest_face)


def _asked(states: States, pair: tuple[int, int], wide: Array, law: Law, face: Array) -> float:
    """Return the least n.(a_i - a_j) of a pair [m/s^2]; its face is written to `face`."""
    pos, vel, _ = states
    i, j = pair
    _, eps, d, k_1, k_0, _, _ = law
    x, y = pos[i, 0] - pos[j, 0], pos[i, 1] - pos[j, 1]
    h = _face_of((x, y, pos[i, 2] - pos[j, 2]), eps, d, face) - wide[0]
    u, v, w = vel[i, 0] - vel[j, 0], vel[i, 1] - vel[j, 1], vel[i, 2] - vel[j, 2]
    rate = face[2] * (face[0] * u + face[1] * v) + face[3] * w - wide[1]
    along = face[0] * v - face[1] * u
    turning = face[2] * along * along / max(np.sqrt(x * x + y * y), eps)
    return float(-k_1 * rate - k_0 * h - turning)


_asked_of = compiled(_asked)


def _push_apart(
    acc: Array, states: States, pairs: tuple[Rows, Rows], wide: Array, law: Law
) -> NDArray[np.bool_]:
    """Correct acc (n, 3) in place to satisfy the barriers; return which vehicles were pushed, (n,).

    Args:
        acc: wanted accelerations [m/s^2].
        states: swarm, then external vehicles.
        pairs: rows i and j of each pair.
        wide: distance to keep from the zone for each pair [m], and its growth [m/s], (pairs, 2).
        law: see Law.
    """
    ref, faces = states[2], np.empty((pairs[0].size, 4))
    own, eps, around, height = law[0], law[1], law[5], law[6]
    asked, pushed = np.empty(pairs[0].size), np.zeros(acc.shape[0], np.bool_)
    for row in range(pairs[0].size):
        asked[row] = _asked_of(states, (pairs[0][row], pairs[1][row]), wide[row], law, faces[row])
    some = np.flatnonzero(asked > -FAR * np.abs(acc).max())
    for turn in range(SWEEPS * some.size):
        row = some[turn % some.size]
        i, j = pairs[0][row], pairs[1][row]
        x, y, n, up = faces[row, 0], faces[row, 1], faces[row, 2], faces[row, 3]
        flat = x * (acc[i, 0] - acc[j, 0]) + y * (acc[i, 1] - acc[j, 1])
        need = asked[row] - n * flat - up * (acc[i, 2] - acc[j, 2])
        if not need > 0.0:
            continue
        goal_x, goal_y = ref[i, 0] - ref[j, 0], ref[i, 1] - ref[j, 1]
        lead = n * around * need * min(1.0, max(0.0, -(goal_x * x + goal_y * y) / (eps + wide[row, 0])))
        lead *= -1.0 if goal_y * x - goal_x * y < -TIE else 1.0
        share = 0.5 if j < own else 1.0
        size = need / (n * n + height * up * up)
        for vehicle, sign in ((i, share), (j, -share)):
            if vehicle < own:
                acc[vehicle, 0] += sign * (size * n * x - lead * y)
                acc[vehicle, 1] += sign * (size * n * y + lead * x)
                acc[vehicle, 2] += sign * size * height * up
                pushed[vehicle] = True
    return pushed


push_apart: Callable[[Array, States, tuple[Rows, Rows], Array, Law], NDArray[np.bool_]] = compiled(
    _push_apart
)
push_apart_plain = _push_apart
