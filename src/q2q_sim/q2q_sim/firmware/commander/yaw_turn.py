"""Shorter turn between two yaws in the 32-bit floats of the high-level commander.

Source: firmware: modules/interface/math3d.h (normalize_radians, shortest_signed_angle_radians). The width
matters where both turns are equally long: half a turn from yaw 0 is flown to the right (yaw decreases) for
+pi and for -pi; from another yaw the last digit decides.
"""

import math

import numpy as np

PI = np.float32(math.pi)
TURN = np.float32(2.0) * PI


@np.errstate(all="ignore")
def wrap_yaw(yaw: float) -> float:
    """Return a yaw [rad] within a half turn of 0, with the firmware's ends; NaN if it is not finite."""
    given = np.float32(yaw)
    half = np.copysign(PI, given)
    return float(np.fmod(given + half, TURN) - half)


def shortest_turn(start: float, end: float) -> float:
    """Return the turn from one wrapped yaw to another [rad]: -pi for half a turn."""
    gap = np.float32(end) - np.float32(start) + PI
    return float(gap - np.floor(gap / TURN) * TURN - PI)
