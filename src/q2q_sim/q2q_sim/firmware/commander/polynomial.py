"""Polynomials of the firmware's high-level commander.

Source: firmware: modules/src/pptraj.c (poly7_nojerk, poly4d_eval), after Mellinger, Kumar, ICRA 2011.
Degree 7 in x, y, z [m] and yaw [rad]: value, velocity and acceleration given at both ends, jerk zero there:
the Hermite piece of q2q_model.trajectory.hermite with k = 4. A goal also has body rates by differential
flatness:

    t = a + g e_z,  z_B = t / |t|,  y_B = z_B x (cos psi, sin psi, 0) / |..|,  x_B = y_B x z_B
    h = (j - (j . z_B) z_B) / |t|,  omega = (-h . y_B, h . x_B, z_B,z psi')

| symbol | name | meaning [unit] |
|---|---|---|
| a j | acc jerk | of the polynomial [m/s^2], [m/s^3] |
| psi | yaw | [rad] |
"""

import math
from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.trajectory.hermite import pieces_from_nodes
from q2q_model.trajectory.polynomials import derive
from q2q_model.vehicle.constants import GRAVITY

ORDER = 8
"""Number of coefficients of an axis."""
HALF = 4
"""Boundary conditions at each end: value and three derivatives."""


@dataclass(frozen=True, slots=True)
class Goal:
    """Point of a trajectory."""

    pos: Array
    """[m], world, (3,)."""
    vel: Array
    """[m/s], world, (3,)."""
    acc: Array
    """[m/s^2], world, (3,)."""
    yaw: float
    """[rad]"""
    ang_vel_body: Array
    """[rad/s], (3,)."""


@dataclass(frozen=True, slots=True)
class Piece:
    """Polynomial of x, y, z, yaw."""

    duration: float
    """[s]"""
    coefficients: Array
    """Ascending powers of time, (4, 8)."""


def goal_at_rest(pos: Array, yaw: float) -> Goal:
    """Return a goal at rest at pos [m], world, (3,), and a yaw [rad]."""
    return Goal(pos, np.zeros(3), np.zeros(3), yaw, np.zeros(3))


@np.errstate(all="ignore")
def piece_between(start: Goal, end: Goal, duration: float) -> Piece:
    """Return the piece from one goal to another in `duration` [s]; for 0 s or less, the end at once."""
    if duration <= 0.0:
        nodes = _node(end)
        coefficients = np.zeros((4, ORDER))
        coefficients[:, :3] = nodes[:, :3] / np.array([1.0, 1.0, 2.0])
        return Piece(duration, coefficients)
    nodes = np.stack([_node(start), _node(end)])  # (2, 4, 4)
    return Piece(duration, pieces_from_nodes(nodes, np.array([duration]))[0])


@np.errstate(all="ignore")
def goal_at(piece: Piece, tau: float) -> Goal:
    """Return the goal `tau` [s] after the piece's start."""
    powers = tau ** np.arange(ORDER)
    value, slope, curve, jerk = (
        derived @ powers[: derived.shape[-1]] for derived in (derive(piece.coefficients, k) for k in range(4))
    )
    rates = _rates(curve[:3], jerk[:3], (float(value[3]), float(slope[3])))
    return Goal(value[:3], slope[:3], curve[:3], float(value[3]), rates)


def cos_sin(angle: float) -> tuple[float, float]:
    """Return cosine and sine; NaN where an uploaded polynomial is not finite, as in C."""
    return (math.cos(angle), math.sin(angle)) if math.isfinite(angle) else (math.nan, math.nan)


def _node(goal: Goal) -> Array:
    """Return value, velocity, acceleration, jerk of x, y, z, yaw, (4, 4)."""
    rows = np.zeros((4, HALF))
    rows[:3, 0], rows[:3, 1], rows[:3, 2] = goal.pos, goal.vel, goal.acc
    rows[3, 0], rows[3, 1] = goal.yaw, goal.ang_vel_body[2]
    return rows


def _rates(acc: Array, jerk: Array, yaw: tuple[float, float]) -> Array:
    """Return the body rates [rad/s], (3,); `yaw` and its rate."""
    thrust = acc + np.array([0.0, 0.0, GRAVITY])
    size = max(float(np.linalg.norm(thrust)), 1e-9)  # free fall: direction undefined
    up = thrust / size
    left = _cross(up, np.array([*cos_sin(yaw[0]), 0.0]))
    left = left / max(float(np.linalg.norm(left)), 1e-9)
    ahead = _cross(left, up)
    turn = (jerk - float(jerk @ up) * up) / size
    return np.array([-float(turn @ left), float(turn @ ahead), float(up[2]) * yaw[1]])


def _cross(a: Array, b: Array) -> Array:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
