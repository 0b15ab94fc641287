"""Accelerations by which vehicles follow their references, or return to them.

On its reference a vehicle's acceleration is that of the reference, else that of the tracking law of (20),
e'' = -k_d e' - k_p e, within acc_max; where jerk is bounded, the shift e shrinks as fast as it can stop
(`approach_speed`).
"""

from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_planner.online.safe.motion.committed_motion import MotionRows
from q2q_planner.online.safe.motion.followed_reference import ReferenceRows
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.motion.vectors import length, limit_row, share_within
from q2q_planner.online.safe.stopping.approach_speed import ApproachLaw, approach_speed

Vector = tuple[float, float, float]
"""x, y and z, world."""

RETURN_BRAKE = 0.75
"""Share of acc_max by which a return of bounded jerk brakes; the rest is for ramps and the reference."""
TINY = 1e-9
"""Shift below which its direction does not matter [m]."""
HEADROOM, LEAST = 0.95, 0.5
"""Largest and least share of speed_max up to which a vehicle of bounded jerk returns: in between less by the
speed that it still gains while acc_max is taken back."""


class ReturnLaw(NamedTuple):
    """Law of the return; fields of SafeReplannerParams."""

    k_p: float
    """[1/s^2]."""
    k_d: float
    """[1/s]."""
    acc: float
    """Largest acceleration [m/s^2]."""
    jerk: float
    """Largest jerk of an axis [m/s^3]; 0 does not bound it."""
    back: ApproachLaw
    """Of the return to the reference, where jerk is bounded."""
    speed: float
    """Up to which a vehicle of bounded jerk returns [m/s]."""


def return_law(params: SafeReplannerParams) -> ReturnLaw:
    """Return the law of the return."""
    back = ApproachLaw(params.pole, RETURN_BRAKE * params.acc_max)
    return ReturnLaw(params.k_p, params.k_d, params.acc_max, params.jerk_max, back, _return_speed(params))


def _return_speed(params: SafeReplannerParams) -> float:
    """Return the speed up to which a vehicle of bounded jerk returns [m/s]."""
    if params.jerk_max == 0.0:
        return params.speed_max
    gained = 0.5 * params.acc_max**2 / params.jerk_max
    return max(LEAST * params.speed_max, min(HEADROOM * params.speed_max, params.speed_max - gained))


@compiled
def towards_reference(rows: MotionRows, reference: ReferenceRows, least: Array, law: ReturnLaw) -> Array:
    """Return the accelerations (n, 3) on the reference, or back to it.

    Vertically, the return accelerates by `least` (n,) [m/s^2] or more.
    """
    acc = reference.acc.copy()
    for row in range(rows.hold.size):
        if rows.on_reference[row]:
            continue
        if law.jerk > 0.0:
            _return_fast(acc, rows, reference, row, law)
        else:
            for axis in range(3):
                rate = rows.vel[row, axis] - reference.vel[row, axis]
                shift = rows.pos[row, axis] - reference.pos[row, axis]
                acc[row, axis] += -law.k_d * rate - law.k_p * shift
        acc[row, 2] = max(acc[row, 2], least[row])
        limit_row(acc, row, law.acc)
    return acc


@compiled
def _return_fast(acc: Array, rows: MotionRows, reference: ReferenceRows, row: int, law: ReturnLaw) -> None:
    """Add the acceleration by which the shift e of a row follows e' = -w(|e|) e / |e| (approach_speed).

    The velocity of a faster reference counts up to `law.speed`. Its acceleration does not where the bound of
    the speed acts: it would lead beyond it.
    """
    vel, asked = rows.vel[row], reference.vel[row]
    share = share_within(asked, law.speed)
    ahead = share * asked[0], share * asked[1], share * asked[2]
    if share < 1.0:
        acc[row] = 0.0
    x, y, z = _apart_by(rows.pos, reference.pos, row)
    u, v, w = vel[0] - ahead[0], vel[1] - ahead[1], vel[2] - ahead[2]
    far = max(length(x, y, z), TINY)
    speed, slope = approach_speed(far, law.back)
    most = _most_closing((x / far, y / far, z / far), ahead, law.speed)
    if speed > most:
        speed, slope, acc[row] = most, 0.0, 0.0
    along = (x * u + y * v + z * w) / far
    turning = speed / far
    for axis, shift, rate in ((0, x, u), (1, y, v), (2, z, w)):
        out = shift / far
        aside = rate - along * out
        acc[row, axis] -= law.back.pole * (rate + speed * out) + slope * along * out + turning * aside


@compiled
def _apart_by(some: Array, other: Array, row: int) -> Vector:
    """Return the difference of a row of two arrays (n, 3)."""
    return some[row, 0] - other[row, 0], some[row, 1] - other[row, 1], some[row, 2] - other[row, 2]


@compiled
def _most_closing(out: Vector, vel: Vector, most: float) -> float:
    """Return the largest w, 0 or more, at which a reference's velocity less w `out` is within `most`."""
    (x, y, z), (u, v, w) = out, vel
    along = x * u + y * v + z * w
    left = along * along + most * most - (u * u + v * v + w * w)
    return max(0.0, along + np.sqrt(left)) if left > 0.0 else 0.0
