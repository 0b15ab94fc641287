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

from collections.abc import Callable

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

NEARER = 0.99
"""Share of the initial distance below which a motion is rejected."""
MOST_STEPS = 1000
"""Most steps of the advancement; a pair that needs more is not proven."""

Motions = tuple[Array, Array, Array, Array, Array]
"""Of n vehicles: pos (n, 3), vel (n, 3), acc (n, 3), hold (n,), growth (n, 2): g0 and g1."""


def _cylinder_distance(x: float, y: float, z: float, eps: float, d: float) -> float:
    """Return the signed distance to I(eps, d) [m]."""
    side, cap = np.sqrt(x * x + y * y) - eps, abs(z) - d
    if side > 0.0 and cap > 0.0:
        return float(np.sqrt(side * side + cap * cap))
    return float(max(side, cap))


def _speed_after(vel: Array, acc: Array, s: float) -> float:
    """Return |vel + acc s| [m/s]."""
    x, y, z = vel[0] + acc[0] * s, vel[1] + acc[1] * s, vel[2] + acc[2] * s
    return float(np.sqrt(x * x + y * y + z * z))


def _braked(s: float, hold: float, speed: float, brake: float) -> float:
    """Return the braking distance from hold to s over the speed at hold [s]."""
    if s <= hold or speed == 0.0:
        return 0.0
    u = min(s - hold, speed / brake)
    return u - 0.5 * brake * u * u / speed


_distance = compiled(_cylinder_distance)
_speed = compiled(_speed_after)
_share = compiled(_braked)


def _stays_out(motions: Motions, i: int, j: int, law: tuple[float, float, float], floor: float) -> bool:
    """Return whether vehicles i and j are proven to stay apart; law = (eps, d, brake).

    Half of `floor` is kept, or half of the initial distance if that is less.
    """
    _, vel, acc, hold, growth = motions
    eps, d, brake = law
    wide, rate = growth[i, 0] + growth[j, 0], growth[i, 1] + growth[j, 1]
    speed_i, speed_j = _speed(vel[i], acc[i], hold[i]), _speed(vel[j], acc[j], hold[j])
    fast_i, fast_j = max(_speed(vel[i], acc[i], 0.0), speed_i), max(_speed(vel[j], acc[j], 0.0), speed_j)
    end = max(hold[i] + speed_i / brake, hold[j] + speed_j / brake)
    end += rate / brake  # extra braking time of a velocity known within `rate`
    s, keep = 0.0, floor
    for step in range(MOST_STEPS):
        share_i, share_j = _share(s, hold[i], speed_i, brake), _share(s, hold[j], speed_j, brake)
        x = _along(motions, i, 0, s, share_i) - _along(motions, j, 0, s, share_j)
        y = _along(motions, i, 1, s, share_i) - _along(motions, j, 1, s, share_j)
        z = _along(motions, i, 2, s, share_i) - _along(motions, j, 2, s, share_j)
        left = _distance(x, y, z, eps, d) - wide - rate * s
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


def _coordinate(motions: Motions, row: int, axis: int, s: float, share: float) -> float:
    """Return one coordinate of a motion at time s [m]; `share` is _braked there."""
    pos, vel, acc, hold, _ = motions
    first = min(s, hold[row])
    there = pos[row, axis] + vel[row, axis] * first + 0.5 * acc[row, axis] * first * first
    return float(there + (vel[row, axis] + acc[row, axis] * first) * share)


_along = compiled(_coordinate)


compiled_stays_out: Callable[[Motions, int, int, tuple[float, float, float], float], bool] = compiled(
    _stays_out
)
stays_out_plain = _stays_out


def _motions_after(motions: Motions, when: Array, brake: float) -> tuple[Array, Array]:
    """Return position and velocity (n, 3) of n motions, each at its own time `when` (n,) [s]."""
    pos, vel, acc, hold, _ = motions
    there, moving = np.empty_like(pos), np.empty_like(vel)
    for row in range(len(hold)):
        first = min(when[row], hold[row])
        speed = _speed(vel[row], acc[row], first)
        late = min(when[row] - first, speed / brake)
        way = late - 0.5 * brake * late * late / speed if speed > 0.0 else 0.0
        left = max(0.0, 1.0 - brake * late / speed) if speed > 0.0 else 0.0
        for axis in range(3):
            rate = vel[row, axis] + acc[row, axis] * first
            begun = pos[row, axis] + vel[row, axis] * first + 0.5 * acc[row, axis] * first * first
            there[row, axis] = begun + rate * way
            moving[row, axis] = rate * left
    return there, moving


_compiled_motions: Callable[[Motions, Array, float], tuple[Array, Array]] = compiled(_motions_after)


def motion_after(motions: Motions, s: float | Array, brake: float) -> tuple[Array, Array]:
    """Return position and velocity (n, 3) of n motions at time s [s], one for all or one each."""
    count = len(motions[3])
    return _compiled_motions(motions, np.full(count, s, dtype=np.float64), brake)


def motion_after_plain(motions: Motions, s: float | Array, brake: float) -> tuple[Array, Array]:
    """Return the same by numpy."""
    pos, vel, acc, hold, _ = motions
    when = np.broadcast_to(s, hold.shape)[:, None]
    first = np.minimum(when, hold[:, None])
    there, moving = pos + vel * first + 0.5 * acc * first**2, vel + acc * first
    speed = np.sqrt((moving**2).sum(-1, keepdims=True))
    some = np.where(speed > 0.0, speed, 1.0)
    u = np.minimum(when - first, speed / brake)
    return there + moving * (u - 0.5 * brake * u**2 / some), moving * np.maximum(0.0, 1.0 - brake * u / some)
