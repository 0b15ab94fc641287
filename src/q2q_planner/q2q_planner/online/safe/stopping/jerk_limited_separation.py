"""Proof, for all time, that two motions of bounded jerk stay out of each other's zone.

The proof is that of `braking` with accelerations: two vehicles whose velocities differ by u now and whose
accelerations add up to at most B approach by at most u s + B s^2 / 2 within s, so a distance L is left until

    s = 2 L / (u + sqrt(u^2 + 2 B L))

| symbol | name | meaning [unit] |
|---|---|---|
| u | speed | speed between both, with the rate of their growth [m/s] |
| B | most | bound of both accelerations, Euclidean [m/s^2] |
| L | free | distance that both may still approach each other by [m] |
"""

import numpy as np

from q2q_model.compiled import HOT, compiled
from q2q_planner.online.safe.stopping.braking import MOST_STEPS, NEARER, BrakingLaw, zone_distance
from q2q_planner.online.safe.stopping.jerk_limited import (
    Axis,
    AxisMotion,
    StoppingMotions,
    ThreeAxisMotion,
    acceleration_bound,
    axes_of,
    axis_at,
    rest_delay,
    rest_of,
)


@compiled(**HOT)
def stays_out_jerk_limited(stopping: StoppingMotions, i: int, j: int, law: BrakingLaw, floor: float) -> bool:
    """Return whether rows i and j are proven to stay out of each other's zone, as `braking.stays_out`."""
    motions, growth = stopping.motions, stopping.motions.growth
    wide, rate = growth[i, 0] + growth[j, 0], growth[i, 1] + growth[j, 1]
    most = acceleration_bound(motions, i, law) + acceleration_bound(motions, j, law)
    one, other = axes_of(stopping, i), axes_of(stopping, j)
    end = max(rest_of(one), rest_of(other)) + rest_delay(rate, law)
    s, keep = 0.0, floor
    for step in range(MOST_STEPS):
        (x, y, z), closing = _relative_motion(one, other, s, law)
        left = zone_distance(x, y, z, law) - wide - rate * s
        if step == 0:
            keep = min(floor, NEARER * left)
        if not (left >= keep and left >= 0.0):  # NaN too
            return False
        speed = rate + closing
        free = left - 0.5 * keep  # half of `keep` remains until then
        s += 2.0 * free / (speed + np.sqrt(speed * speed + 2.0 * most * free)) if free > 0.0 else 0.0
        if s >= end:
            return True
    return False


@compiled(**HOT)
def _relative_motion(
    one: ThreeAxisMotion, other: ThreeAxisMotion, s: float, law: BrakingLaw
) -> tuple[Axis, float]:
    """Return the position of one motion from another at time s [m], and the speed between them [m/s]."""
    x, u = _relative_axis(one[0], other[0], s, law)
    y, v = _relative_axis(one[1], other[1], s, law)
    z, w = _relative_axis(one[2], other[2], s, law)
    return (x, y, z), np.sqrt(u * u + v * v + w * w)


@compiled(**HOT)
def _relative_axis(one: AxisMotion, other: AxisMotion, s: float, law: BrakingLaw) -> tuple[float, float]:
    """Return position [m] and velocity [m/s] of one axis from another at time s [s]."""
    here, there = axis_at(one, s, law), axis_at(other, s, law)
    return here[0] - there[0], here[1] - there[1]
