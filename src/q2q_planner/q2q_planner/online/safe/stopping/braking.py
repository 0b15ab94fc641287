"""Proof, for all time, that two vehicles can still stop outside each other's zone.

A motion holds an acceleration a for a time h, then brakes on a straight line to rest with deceleration b:

    r(s) = r + v s + a s^2 / 2                        0 <= s <= h
    r(s) = r_h + v_h / |v_h| (|v_h| u - b u^2 / 2)    u = min(s - h, |v_h| / b)

Conservative advancement (Mirtich, Impulse-based dynamic simulation, 1996) decides whether the relative motion
of a pair stays outside the cylinder I(eps, d), grown by g0 + g1 s for the uncertainty of both: the signed
distance changes no faster than the sum of both speeds and the growth rate, so no contact is possible within
distance over rate. It stops at rest, or when the distance falls below a floor. No instant is skipped, so a
pass is a proof.

Braking projects velocities towards zero, which does not increase the difference of two velocities: a vehicle
whose velocity is known within w stays, braking, within w s of the motion from its known velocity.

| symbol | name | meaning [unit] |
|---|---|---|
| a, h | acc, hold | acceleration [m/s^2] held for h [s] |
| b | brake | deceleration to rest [m/s^2] |
| g0, g1 | growth | growth of the zone [m] and its rate [m/s] |
| eps, d | zone | radius and half height of the zone [m] |
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import BORROWING, compiled
from q2q_model.signals.values import Array

NEARER = 0.99
"""Share of the initial distance below which a motion is rejected."""
REST = 1e-12
"""Share of a velocity that only rounding leaves after the braking time [-]: it is rest."""
MOST_STEPS = 1000
"""Most steps of the advancement; a pair that needs more is not proven."""


class Motions(NamedTuple):
    """Motions of n vehicles: an acceleration held for a time, then braking to rest."""

    pos: Array
    """[m], (n, 3)."""
    vel: Array
    """[m/s], (n, 3)."""
    acc: Array
    """[m/s^2], (n, 3)."""
    hold: Array
    """[s], (n,)."""
    growth: Array
    """g0 [m] and g1 [m/s], (n, 2)."""
    jerk: Array
    """Held jerk [m/s^3], (n, 3), where the law bounds it (`jerk_limited`); `acc` is then where it starts."""


class BrakingLaw(NamedTuple):
    """Zone, deceleration and jerk of a proof."""

    eps: float
    """Radius of the zone [m]."""
    d: float
    """Half height of the zone [m]."""
    brake: float
    """Deceleration; where jerk is bounded, the largest acceleration of an axis [m/s^2]."""
    jerk: float = 0.0
    """Largest jerk of an axis [m/s^3]; 0 does not bound it."""


@compiled
def zone_distance(x: float, y: float, z: float, law: BrakingLaw) -> float:
    """Return the signed distance to I(eps, d) [m] of a vehicle at x, y, z [m] from another."""
    side, cap = np.sqrt(x * x + y * y) - law.eps, abs(z) - law.d
    if side > 0.0 and cap > 0.0:
        return float(np.sqrt(side * side + cap * cap))
    return float(max(side, cap))


@compiled(**BORROWING)
def _speed(vel: Array, acc: Array, s: float) -> float:
    """Return |vel + acc s| [m/s]."""
    x, y, z = vel[0] + acc[0] * s, vel[1] + acc[1] * s, vel[2] + acc[2] * s
    return float(np.sqrt(x * x + y * y + z * z))


@compiled
def _braking_share(s: float, hold: float, speed: float, brake: float) -> float:
    """Return the braking distance from hold to s over the speed at hold [s]."""
    if s <= hold or speed == 0.0:
        return 0.0
    u = min(s - hold, speed / brake)
    return u - 0.5 * brake * u * u / speed


@compiled(**BORROWING)
def _coordinate(motions: Motions, row: int, axis: int, s: float, share: float) -> float:
    """Return one coordinate of a motion at time s [m]; `share` is _braking_share there."""
    vel, acc = motions.vel[row, axis], motions.acc[row, axis]
    first = min(s, motions.hold[row])
    there = motions.pos[row, axis] + vel * first + 0.5 * acc * first * first
    return float(there + (vel + acc * first) * share)


@compiled(**BORROWING)
def stays_out(motions: Motions, i: int, j: int, law: BrakingLaw, floor: float) -> bool:
    """Return whether rows i and j of the motions are proven to stay out of each other's zone.

    Half of `floor` [m] is kept, or half of the initial distance if that is less.
    """
    vel, acc, hold, growth, brake = motions.vel, motions.acc, motions.hold, motions.growth, law.brake
    wide, rate = growth[i, 0] + growth[j, 0], growth[i, 1] + growth[j, 1]
    speed_i, speed_j = _speed(vel[i], acc[i], hold[i]), _speed(vel[j], acc[j], hold[j])
    fast_i, fast_j = max(_speed(vel[i], acc[i], 0.0), speed_i), max(_speed(vel[j], acc[j], 0.0), speed_j)
    end = max(hold[i] + speed_i / brake, hold[j] + speed_j / brake)
    end += rate / brake  # extra braking time of a velocity known within `rate`
    s, keep = 0.0, floor
    for step in range(MOST_STEPS):
        share_i = _braking_share(s, hold[i], speed_i, brake)
        share_j = _braking_share(s, hold[j], speed_j, brake)
        x = _coordinate(motions, i, 0, s, share_i) - _coordinate(motions, j, 0, s, share_j)
        y = _coordinate(motions, i, 1, s, share_i) - _coordinate(motions, j, 1, s, share_j)
        z = _coordinate(motions, i, 2, s, share_i) - _coordinate(motions, j, 2, s, share_j)
        left = zone_distance(x, y, z, law) - wide - rate * s
        if step == 0:
            keep = min(floor, NEARER * left)
        if not (left >= keep and left >= 0.0):  # NaN too
            return False
        most = rate
        most += fast_i if s < hold[i] else max(0.0, speed_i - brake * (s - hold[i]))
        most += fast_j if s < hold[j] else max(0.0, speed_j - brake * (s - hold[j]))
        if most == 0.0:
            return True
        s += (left - 0.5 * keep) / most  # half of `keep` remains until then
        if s >= end:
            return True
    return False


@compiled
def motions_after(motions: Motions, when: Array, brake: float) -> tuple[Array, Array]:
    """Return position and velocity (n, 3) of n motions, each at its own time `when` (n,) [s]."""
    pos, vel, acc = motions.pos, motions.vel, motions.acc
    there, moving = np.empty_like(pos), np.empty_like(vel)
    for row in range(motions.hold.size):
        first = min(when[row], motions.hold[row])
        speed = _speed(vel[row], acc[row], first)
        late = min(when[row] - first, speed / brake)
        distance = _braking_share(when[row], motions.hold[row], speed, brake)
        left = 1.0 - brake * late / speed if speed > 0.0 else 0.0
        if left < REST:
            left = 0.0
        for axis in range(3):
            rate = vel[row, axis] + acc[row, axis] * first
            begun = pos[row, axis] + vel[row, axis] * first + 0.5 * acc[row, axis] * first * first
            there[row, axis] = begun + rate * distance
            moving[row, axis] = rate * left
    return there, moving


def motion_after(motions: Motions, s: float | Array, brake: float) -> tuple[Array, Array]:
    """Return position and velocity (n, 3) of n motions at time s [s], one for all or one each."""
    return motions_after(motions, np.full(len(motions.hold), s, dtype=np.float64), brake)
