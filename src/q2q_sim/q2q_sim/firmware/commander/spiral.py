"""Arc of a spiral, as flown by the firmware's high-level commander.

Source: firmware: modules/src/planner.c (plan_spiral_from). The arc turns by an angle of at most 2 pi while
radius and height change linearly; it is one polynomial that matches position, velocity and acceleration at
both ends. In polar form about its centre c, with s = -1 to the left, +1 to the right:

    angle' = omega = -s angle / T,  r' = (r_f - r_0) / T
    p = c + r u(phi),  v = r' u + r omega n,  a = -r omega^2 u + 2 r' omega n

u points from the centre to the vehicle, n is u turned left by 90 deg. Forward, u is the vehicle's side away
from the turn; sideways, the vehicle looks at the centre (to the right) or away from it.
"""

import math
from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.firmware.commander.polynomial import Goal, Piece, piece_between
from q2q_sim.firmware.commander.yaw_turn import wrap_yaw


@dataclass(frozen=True, slots=True)
class Spiral:
    """Shape of a spiral."""

    angle: float
    """[rad], within 2 pi."""
    radius_start: float
    """[m]"""
    radius_end: float
    """[m]"""
    ascent: float
    """[m]"""
    duration: float
    """[s]; an arc in 0 s is NaN."""
    sideways: bool
    clockwise: bool


@np.errstate(all="ignore")
def spiral_piece(here: Goal, spiral: Spiral) -> Piece:
    """Return the polynomial of a spiral that starts at `here`."""
    sense = 1.0 if spiral.clockwise else -1.0
    turned = -sense * min(max(spiral.angle, -2.0 * math.pi), 2.0 * math.pi)
    start = wrap_yaw(here.yaw)
    end, duration = start + turned, np.float64(spiral.duration)
    r0, r1 = max(spiral.radius_start, 0.0), max(spiral.radius_end, 0.0)
    growth = float((r1 - r0) / duration)
    rate, climb = float(turned / duration), float(spiral.ascent / duration)
    first = _polar(_outward(start, sense, spiral.sideways), (r0, growth), rate)
    last = _polar(_outward(end, sense, spiral.sideways), (r1, growth), rate)
    centre = here.pos - np.array([*first[0], 0.0])
    rates = np.array([0.0, 0.0, rate])
    stop = centre + np.array([*last[0], spiral.ascent])
    begin = Goal(here.pos, np.array([*first[1], climb]), np.array([*first[2], 0.0]), start, rates)
    finish = Goal(stop, np.array([*last[1], climb]), np.array([*last[2], 0.0]), end, rates)
    return piece_between(begin, finish, spiral.duration)


def _outward(yaw: float, sense: float, sideways: bool) -> float:
    """Return the direction from the centre to a vehicle of this yaw [rad]."""
    if sideways:
        return yaw + (math.pi if sense > 0.0 else 0.0)
    return yaw + sense * 0.5 * math.pi


def _polar(angle: float, radius: tuple[float, float], rate: float) -> tuple[Array, Array, Array]:
    """Return r u, its velocity and acceleration, horizontal, (2,) each."""
    r, growth = radius
    out = np.array([math.cos(angle), math.sin(angle)])
    left = np.array([-out[1], out[0]])
    return r * out, growth * out + r * rate * left, -r * rate * rate * out + 2.0 * growth * rate * left
