"""Prove, in closed form and for all time, that two vehicles can still stop outside each other's zone.

A motion holds an acceleration a for a time h, then brakes straight to rest with deceleration b:

    r(s) = r + v s + a s^2 / 2                        0 <= s <= h
    r(s) = r_h + v_h / |v_h| (|v_h| u - b u^2 / 2)    u = min(s - h, |v_h| / b)

Whether the relative motion of a pair keeps out of the cylinder I(eps, d), grown by g0 + g1 s for what is
not known of the two, is decided by conservative advancement (Mirtich, Impulse-based dynamic simulation,
1996): the signed distance changes no faster than the speeds of both and the growth, so distance over that
rate is a time in which nothing can happen. It ends at rest, or where less than a floor is left. No sample
of time is skipped, so a pass is a proof.

Braking is a projection of velocities towards zero, which brings no two velocities further apart: a
neighbour whose velocity is known within w is, braking, within w s of where its known velocity leads.

| symbol | name | meaning [unit] |
|---|---|---|
| a, h | acc, hold | acceleration [m/s^2] held for h [s] |
| b | brake | deceleration to rest [m/s^2] |
| g0, g1 | growth | what the zone grows by [m], and its rate [m/s] |
| eps, d | zone | radius and half height of the zone [m] |
"""

from collections.abc import Callable

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals import Array

NEARER = 0.99
"""Share of the distance now that a motion may come down to."""
MOST_STEPS = 1000
"""Steps of the advancement; a pair that needs more counts as not proven."""

Motions = tuple[Array, Array, Array, Array, Array]
"""Of n vehicles: pos (n, 3), vel (n, 3), acc (n, 3), hold (n,), growth (n, 2): g0 and g1."""


def _moved(
    pos: Array, vel: Array, acc: Array, hold: float, after: tuple[float, float]
) -> tuple[Array, Array]:
    """Return position and velocity of one motion at `after` = (s, brake)."""
    s, brake = after
    first = min(s, hold)
    there = pos + vel * first + 0.5 * acc * first * first
    speed_vec = vel + acc * first
    speed = np.sqrt((speed_vec * speed_vec).sum())
    if s <= hold or speed == 0.0:
        return there, speed_vec
    u = min(s - hold, speed / brake)
    share = u - 0.5 * brake * u * u / speed
    return there + speed_vec * share, speed_vec * max(0.0, 1.0 - brake * u / speed)


def _rest_time(vel: Array, acc: Array, hold: float, brake: float) -> float:
    """Return when a motion has come to rest [s]."""
    end = vel + acc * hold
    return float(hold + np.sqrt((end * end).sum()) / brake)


def _cylinder_distance(x: float, y: float, z: float, zone: tuple[float, float]) -> float:
    """Return the signed distance to I(eps, d) [m]."""
    side = np.sqrt(x * x + y * y) - zone[0]
    cap = abs(z) - zone[1]
    if side > 0.0 and cap > 0.0:
        return float(np.sqrt(side * side + cap * cap))
    return float(max(side, cap))


_compiled_moved: Callable[..., tuple[Array, Array]] = compiled(_moved)
_compiled_rest: Callable[..., float] = compiled(_rest_time)
_compiled_distance: Callable[..., float] = compiled(_cylinder_distance)


def _stays_out(motions: Motions, i: int, j: int, law: tuple[float, float, float], floor: float) -> bool:
    """Return True where vehicles i and j are proven to keep out; law = (eps, d, brake).

    Half of `floor` is kept, or of the distance now, where that is less.
    """
    pos, vel, acc, hold, growth = motions
    eps, d, brake = law
    wide, rate = growth[i, 0] + growth[j, 0], growth[i, 1] + growth[j, 1]
    unsure = rate / brake  # a velocity known within `rate` may take this longer to brake
    end = max(_compiled_rest(vel[i], acc[i], hold[i], brake), _compiled_rest(vel[j], acc[j], hold[j], brake))
    end += unsure
    s, keep = 0.0, floor
    for step in range(MOST_STEPS):
        pos_i, vel_i = _compiled_moved(pos[i], vel[i], acc[i], hold[i], (s, brake))
        pos_j, vel_j = _compiled_moved(pos[j], vel[j], acc[j], hold[j], (s, brake))
        rel = pos_i - pos_j
        left = _compiled_distance(rel[0], rel[1], rel[2], (eps, d)) - wide - rate * s
        if step == 0:
            keep = min(floor, NEARER * left)
        if not (left >= keep and left >= 0.0):  # also where a number is NaN
            return False
        speed = rate
        for here, held, push in ((vel_i, hold[i], acc[i]), (vel_j, hold[j], acc[j])):
            speed += np.sqrt((here * here).sum())
            if s < held:
                speed += np.sqrt((push * push).sum()) * (held - s)
        if speed == 0.0:
            return True
        s += (left - 0.5 * keep) / speed  # half of `keep` is left in between
        if s >= end:
            return True
    return False


compiled_stays_out: Callable[[Motions, int, int, tuple[float, float, float], float], bool] = compiled(
    _stays_out
)
stays_out_plain = _stays_out


def motion_after(motions: Motions, s: float | Array, brake: float) -> tuple[Array, Array]:
    """Return position and velocity (n, 3) of n motions at time s [s], one for all or one each."""
    pos, vel, acc, hold, _ = motions
    when = np.broadcast_to(s, hold.shape)[:, None]
    first = np.minimum(when, hold[:, None])
    there, moving = pos + vel * first + 0.5 * acc * first**2, vel + acc * first
    speed = np.sqrt((moving**2).sum(-1, keepdims=True))
    some = np.where(speed > 0.0, speed, 1.0)
    u = np.minimum(when - first, speed / brake)
    return there + moving * (u - 0.5 * brake * u**2 / some), moving * np.maximum(0.0, 1.0 - brake * u / some)
