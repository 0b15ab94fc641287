"""Take the usual tick in compiled loops: every vehicle's own sample, after a tick that was usual too.

On few vehicles numpy's calls cost ten times the arithmetic. A tick in which any vehicle is unusual is left
untouched, and told by False: then positions.py and attitudes.py, whose equations these are, sort it out.

| symbol | name | meaning [unit] |
|---|---|---|
| x | state | rows p v a, columns x y z, (n, 3, 3) |
| K | gain | settled gains of p, v, a, (n, 3) |
| q0 | quat | last orientation, x y z w, (n, 4) |
| w | rate | body rate [rad/s], (n, 3) |
| | moving | tau, what of a moves p, what of it changes v; gates of position and velocity, room [m]; exact |
| | turning | tau, least cosine of half a believable turn, blend of the low pass |

Gates are half sides of boxes that lie within every vehicle's; `exact` above 0 passes positions through.
"""

import math

from q2q_model.compiled import compiled
from q2q_model.flights.outliers import REPEAT_STEP
from q2q_model.signals.values import Array

POS, VEL, QUAT, RATE = slice(0, 3), slice(3, 6), slice(6, 10), slice(10, 13)
"""Columns of what a tick gives, (n, 13)."""
UNIT_TOLERANCE = 0.05
"""A quaternion whose length is further from 1 is damaged: a float32 one is within 1e-6, four digits 1e-3."""
_TINY = 1e-150
"""Stands for zero in the sine of a turn."""

_TAU, _ACC_TO_POS, _ACC_TO_VEL, _GATE, _REACH, _ROOM, _EXACT = range(7)


def _usual_move(state: Array, pose: Array, heard: Array, moving: Array) -> bool:
    """Return whether one vehicle's sample is within all gates, and no old pose again."""
    same, jumped = True, False
    for k in range(3):
        expected = state[0, k] + moving[_TAU] * state[1, k] + moving[_ACC_TO_POS] * state[2, k]
        near = abs(pose[k] - expected) <= moving[_GATE] and abs(pose[k] - state[0, k]) <= moving[_REACH]
        if not near or abs(pose[k]) > moving[_ROOM]:  # also NaN
            return False
        same = same and pose[k] == heard[k]
        jumped = jumped or abs(expected - state[0, k]) > REPEAT_STEP
    for k in range(3, 7):
        same = same and (pose[k] == heard[k] or (math.isnan(pose[k]) and math.isnan(heard[k])))
    return not (same and jumped)


def _move(state: Array, pose: Array, gain: Array, moving: Array) -> None:
    for k in range(3):
        p = state[0, k] + moving[_TAU] * state[1, k] + moving[_ACC_TO_POS] * state[2, k]
        v, a = state[1, k] + moving[_ACC_TO_VEL] * state[2, k], state[2, k]
        miss = pose[k] - p
        state[0, k] = pose[k] if moving[_EXACT] > 0.0 else p + gain[0] * miss
        state[1, k], state[2, k] = v + gain[1] * miss, a + gain[2] * miss


def _glide_positions(
    poses: tuple[Array, Array], state: Array, gain: Array, moving: Array, out: Array
) -> bool:
    pose, heard = poses
    for i in range(pose.shape[0]):
        if not usual_move(state[i], pose[i], heard[i], moving):
            return False
    for i in range(pose.shape[0]):
        move(state[i], pose[i], gain[i], moving)
        for k in range(3):
            out[i, k], out[i, 3 + k] = state[i, 0, k], state[i, 1, k]
    return True


def _turn_of(quat: Array, pose: Array, turn: Array) -> float:
    """Write q0* q / |q|; return |q|, or NaN where q is damaged."""
    x, y, z, w = pose[3], pose[4], pose[5], pose[6]
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(length - 1.0) <= UNIT_TOLERANCE:
        return math.nan
    x, y, z, w = x / length, y / length, z / length, w / length
    a, b, c, d = -quat[0], -quat[1], -quat[2], quat[3]
    turn[0] = d * x + a * w + b * z - c * y
    turn[1] = d * y + b * w + c * x - a * z
    turn[2] = d * z + c * w + a * y - b * x
    turn[3] = d * w - a * x - b * y - c * z
    return length


def _turned(quat: Array, rate: Array, pose: Array, turn: Array, turning: tuple[float, float, float]) -> None:
    """Take an attitude and the rate that led to it; `turn` is `turn_of`'s."""
    elapsed, _, blend = turning
    length = turn_of(quat, pose, turn)
    sign = math.copysign(1.0, turn[3])
    sine = max(math.sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]), _TINY)
    scale = sign * 2.0 * math.atan2(sine, abs(turn[3])) / sine / elapsed
    for k in range(4):
        quat[k] = sign * pose[3 + k] / length
    for k in range(3):
        rate[k] += blend * (scale * turn[k] - rate[k])


def _glide_attitudes(
    pose: Array, quat: Array, rate: Array, turning: tuple[float, float, float], turn: Array
) -> bool:
    for i in range(pose.shape[0]):
        whole = turn_of(quat[i], pose[i], turn) > 0.0
        if not (whole and abs(turn[3]) >= turning[1]):
            return False
    for i in range(pose.shape[0]):
        turned(quat[i], rate[i], pose[i], turn, turning)
    return True


usual_move, move = compiled(_usual_move), compiled(_move)
turn_of, turned = compiled(_turn_of), compiled(_turned)
glide_positions = compiled(_glide_positions)
"""Move `state` on and write POS, VEL of `out`: ((pose, heard) (n, 7) each, state, gain, moving (7,), out);
False, and nothing changed, where a vehicle is unusual."""
glide_attitudes = compiled(_glide_attitudes)
"""Turn `quat` and `rate` on: (pose (n, 7), quat, rate, turning, room for a turn (4,)); False as above."""
