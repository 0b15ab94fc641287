"""Control barrier on accelerations: pairs approach a zone no faster than they can stop.

For a pair with signed distance h to the zone and outward normal n the relative acceleration must satisfy

    n.(a_i - a_j) >= -k_1 h' - k_0 h - (curvature),    h' = n.(v_i - v_j)

(an exponential control barrier function, Nguyen and Sreenath, 2016; pairwise as Wang, Ames and Egerstedt,
Safety barrier certificates for collisions-free multirobot systems, 2017). The violation is corrected along n,
half by each vehicle of the swarm, or all by one that meets an external vehicle; where jerk is bounded, the
nearer of two to its reference takes more, so that those far away pass. SWEEPS Gauss-Seidel sweeps resolve
several pairs at once. The curvature term (tangential speed)^2 / radius accounts for the rotation of n along
the cylinder's side.

If the references are on opposite sides of each other, a correction perpendicular to n leads around: along the
side to that of the reference, or to the right if it is straight behind, which breaks the symmetric tie. Above
each other, it leads outwards, off the face; where the references are apart horizontally, they lead there.

Downwash disturbs heights and formations hold them, so horizontal corrections are preferred: of all p with
n.p = need, the one that minimises |p_flat|^2 + p_up^2 / w, where w below 1 is the weight of vertical ones:
p = need (n_flat, w n_up) / (n_flat^2 + w n_up^2). For vehicles above each other, n_flat = 0, it is vertical.
The vertical acceleration of a vehicle is at least `least`, which keeps it off the floor (`height_bound`).
What a vehicle there cannot take, the one above it takes; a correction of such a pair leads outwards.
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import HOT, compiled
from q2q_model.signals.values import Array, Mask
from q2q_planner.online.safe.stopping.broad_phase import Pairs

SWEEPS = 4
FAR = 6.0
"""Required acceleration below -FAR times the largest desired one: the pair is too far apart to matter."""
ON_AXIS = 1e-9
"""Horizontal distance below which the direction is taken as x [m]."""
SHIFTED = 0.1
"""Shift from a reference that is added to those of both when a correction is shared [m]."""
TIE = 0.02
"""Lateral offset below which a reference counts as straight behind the other [m]."""

_X, _Y, _FLAT, _UP = range(4)
"""Columns of a face: horizontal direction (x, y) from the axis, normal (flat, up) of the nearest face."""


class BarrierStates(NamedTuple):
    """States of the swarm, then of external vehicles, whose reference is their position."""

    pos: Array
    """[m], (n, 3)."""
    vel: Array
    """[m/s], (n, 3)."""
    ref: Array
    """Position of the reference [m], (n, 3)."""
    least: Array
    """Least vertical acceleration of the swarm's vehicles [m/s^2], (own,)."""


class BarrierLaw(NamedTuple):
    """Gains of the barrier."""

    own: int
    """Rows of the swarm."""
    eps: float
    """Radius of the zone [m]."""
    d: float
    """Half height of the zone [m]."""
    k_1: float
    """[1/s]."""
    k_0: float
    """[1/s^2]."""
    around: float
    """Tangential share of a correction: it leads around the other vehicle."""
    height: float
    """w, weight of vertical corrections over horizontal ones."""
    shares: bool
    """The nearer to its reference, the more of a correction a vehicle takes; else each takes half."""


@compiled(**HOT)
def _nearest_face(rel_pos: tuple[float, float, float], eps: float, d: float, face: Array) -> float:
    """Write the nearest face of I(eps, d) to `face`, (4,); return h."""
    x, y, z = rel_pos
    across = np.sqrt(x * x + y * y)
    side, cap = across - eps, abs(z) - d
    face[_X], face[_Y] = (x / across, y / across) if across > ON_AXIS else (1.0, 0.0)
    up = 1.0 if z >= 0.0 else -1.0
    if side > 0.0 and cap > 0.0:
        h = np.sqrt(side * side + cap * cap)
        face[_FLAT], face[_UP] = side / h, up * cap / h
        return float(h)
    face[_FLAT], face[_UP] = (1.0, 0.0) if side >= cap else (0.0, up)
    return float(max(side, cap))


@compiled(**HOT)
def _required(
    states: BarrierStates, pair: tuple[int, int], wide: Array, law: BarrierLaw, face: Array
) -> float:
    """Return the least n.(a_i - a_j) of a pair [m/s^2]; its face is written to `face`."""
    pos, vel = states.pos, states.vel
    i, j = pair
    x, y = pos[i, 0] - pos[j, 0], pos[i, 1] - pos[j, 1]
    h = _nearest_face((x, y, pos[i, 2] - pos[j, 2]), law.eps, law.d, face) - wide[0]
    u, v, w = vel[i, 0] - vel[j, 0], vel[i, 1] - vel[j, 1], vel[i, 2] - vel[j, 2]
    rate = face[_FLAT] * (face[_X] * u + face[_Y] * v) + face[_UP] * w - wide[1]
    along = face[_X] * v - face[_Y] * u
    turning = face[_FLAT] * along * along / max(np.sqrt(x * x + y * y), law.eps)
    return float(-law.k_1 * rate - law.k_0 * h - turning)


@compiled(**HOT)
def _violation(acc: Array, i: int, j: int, required: float, face: Array) -> float:
    """Return by how much n.(a_i - a_j) is below `required` [m/s^2]."""
    flat = face[_X] * (acc[i, 0] - acc[j, 0]) + face[_Y] * (acc[i, 1] - acc[j, 1])
    return float(required - face[_FLAT] * flat - face[_UP] * (acc[i, 2] - acc[j, 2]))


@compiled(**HOT)
def _lead(ref: Array, i: int, j: int, face: Array, reach: float) -> float:
    """Return the signed share, within 1, of a correction that leads around: full for opposite references."""
    goal_x, goal_y = ref[i, 0] - ref[j, 0], ref[i, 1] - ref[j, 1]
    opposite = min(1.0, max(0.0, -(goal_x * face[_X] + goal_y * face[_Y]) / reach))
    return float(-opposite if goal_y * face[_X] - goal_x * face[_Y] < -TIE else opposite)


@compiled(**HOT)
def _lead_out(ref: Array, i: int, j: int, face: Array, reach: tuple[float, float]) -> float:
    """Return the share, within 1, of a correction that leads off the upper or lower face.

    `reach` is the radius and half height that is kept [m].
    """
    x, y = ref[i, 0] - ref[j, 0], ref[i, 1] - ref[j, 1]
    over = max(0.0, 1.0 - np.sqrt(x * x + y * y) / reach[0])
    return float(over * min(1.0, max(0.0, -(ref[i, 2] - ref[j, 2]) * face[_UP] / reach[1])))


@compiled(**HOT)
def _shift(states: BarrierStates, row: int) -> float:
    """Return the distance of a vehicle from its reference [m], and SHIFTED."""
    x, y = states.pos[row, 0] - states.ref[row, 0], states.pos[row, 1] - states.ref[row, 1]
    z = states.pos[row, 2] - states.ref[row, 2]
    return float(np.sqrt(x * x + y * y + z * z) + SHIFTED)


@compiled(**HOT)
def _stuck(acc: Array, states: BarrierStates, pair: tuple[int, int], up: float, law: BarrierLaw) -> int:
    """Return the lower of a pair, by the sign of `up`, if it may not accelerate further down, else -1."""
    low = pair[0] if up < 0.0 else pair[1]
    return low if low < law.own and acc[low, 2] <= states.least[low] else -1


@compiled(**HOT)
def _share(states: BarrierStates, i: int, j: int, stuck: int, law: BarrierLaw) -> float:
    """Return the share of a correction that i takes: all where j is external, none where i is stuck."""
    if j >= law.own or stuck == j:
        return 1.0
    if stuck == i:
        return 0.0
    if not law.shares:
        return 0.5
    first, second = _shift(states, i), _shift(states, j)
    return second / (first + second)


@compiled
def filter_accelerations(
    acc: Array, states: BarrierStates, pairs: Pairs, wide: Array, law: BarrierLaw
) -> Mask:
    """Correct acc (n, 3) in place to satisfy the barriers; return which vehicles were corrected, (n,).

    Args:
        acc: desired accelerations [m/s^2].
        states: see BarrierStates.
        pairs: rows i and j of each pair.
        wide: distance to keep from the zone for each pair [m], and its growth [m/s], (pairs, 2).
        law: see BarrierLaw.
    """
    faces, required = np.empty((pairs.i.size, 4)), np.empty(pairs.i.size)
    pushed = np.zeros(acc.shape[0], np.bool_)
    for row in range(pairs.i.size):
        required[row] = _required(states, (pairs.i[row], pairs.j[row]), wide[row], law, faces[row])
    near = np.flatnonzero(required > -FAR * np.abs(acc).max())
    for _ in range(SWEEPS):
        for pair in near:
            i, j, face = pairs.i[pair], pairs.j[pair], faces[pair]
            need = _violation(acc, i, j, required[pair], face)
            if not need > 0.0:
                continue
            reach = law.eps + wide[pair, 0], law.d + wide[pair, 0]
            lead = face[_FLAT] * law.around * need * _lead(states.ref, i, j, face, reach[0])
            out, stuck = 0.0, -1
            if face[_UP] != 0.0:
                stuck = _stuck(acc, states, (i, j), face[_UP], law)
                around = law.around * _lead_out(states.ref, i, j, face, reach)
                out = need * (around if stuck < 0 else abs(face[_UP]))
            size = need / (face[_FLAT] * face[_FLAT] + law.height * face[_UP] * face[_UP])
            flat = size * face[_FLAT] + out
            share = _share(states, i, j, stuck, law)
            for vehicle, sign in ((i, share), (j, share - 1.0)):
                if vehicle < law.own:
                    acc[vehicle, 0] += sign * (flat * face[_X] - lead * face[_Y])
                    acc[vehicle, 1] += sign * (flat * face[_Y] + lead * face[_X])
                    climb = acc[vehicle, 2] + sign * size * law.height * face[_UP]
                    acc[vehicle, 2] = max(climb, states.least[vehicle])
                    pushed[vehicle] = True
    return pushed
