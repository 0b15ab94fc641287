"""Rigid body over one step: acceleration, body rates and attitude as a quaternion, without small angles."""

import math

from q2q_control.attitude.attitude_law import AxisValues
from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Four, Three
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.plant.body.state_row import Two

SMALL_SQUARE = 1e-3
"""Square of an angle up to which the series of its sine and cosine are exact [rad^2]."""


@compiled(**BORROWING)
def acceleration(quat: Four, rotors: Four, push: Three, mass: float) -> Three:
    """Return the acceleration [m/s^2], world, by rotor thrusts [N], a push [m/s^2], world, and gravity."""
    x, y, z, w = quat
    thrust_acc = (rotors[0] + rotors[1] + rotors[2] + rotors[3]) / mass
    return (
        thrust_acc * 2.0 * (x * z + w * y) + push[0],
        thrust_acc * 2.0 * (y * z - w * x) + push[1],
        thrust_acc * (1.0 - 2.0 * (x * x + y * y)) - GRAVITY + push[2],
    )


@compiled(**BORROWING)
def rate_after(rate: Three, torque: Three, inertia: AxisValues, step: float) -> Three:
    """Return the body rates [rad/s] after a step [s] under the torque of rotors and air [N m], body.

    `inertia` is that about x, y, z [kg m^2].
    """
    p, q, r = rate
    ix, iy, iz = inertia[0], inertia[1], inertia[2]
    return (
        p + step * (torque[0] + (iy - iz) * q * r) / ix,
        q + step * (torque[1] + (iz - ix) * p * r) / iy,
        r + step * (torque[2] + (ix - iy) * p * q) / iz,
    )


@compiled(**BORROWING)
def small_half_turn(square: float) -> Two:
    """Return sin x / x and cos x for x^2 = square [rad^2] up to SMALL_SQUARE; exact to the last digit."""
    sine = 1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0)))
    rest = 1.0 / 24.0 - square * (1.0 / 720.0 - square * (1.0 / 40320.0))
    return sine, 1.0 - square * (0.5 - square * rest)


@compiled(**BORROWING)
def half_turn_of(square: float) -> Two:
    """Return sin x / x and cos x for x^2 = square [rad^2]."""
    if square > SMALL_SQUARE:
        x = math.sqrt(square)
        return math.sin(x) / x, math.cos(x)
    return small_half_turn(square)


@compiled(**BORROWING)
def half_turn_squared(rate: Three, step: float) -> float:
    """Return the square of half the angle of a step's turn [rad^2], at body rates [rad/s]."""
    p, q, r = rate
    return 0.25 * step * step * (p * p + q * q + r * r)


@compiled(**BORROWING)
def quat_after(quat: Four, rate: Three, half_turn: Two, step: float) -> Four:
    """Return the attitude x y z w after one step [s] at body rates [rad/s].

    `half_turn` is sin x / x, cos x of half the angle.
    """
    s, c = half_turn
    s *= 0.5 * step
    ex, ey, ez = s * rate[0], s * rate[1], s * rate[2]
    x, y, z, w = quat
    nx = w * ex + x * c + y * ez - z * ey
    ny = w * ey - x * ez + y * c + z * ex
    nz = w * ez + x * ey - y * ex + z * c
    nw = w * c - x * ex - y * ey - z * ez
    scale = 1.5 - 0.5 * (nx * nx + ny * ny + nz * nz + nw * nw)  # 1 / sqrt near 1, by Newton
    return nx * scale, ny * scale, nz * scale, nw * scale
