"""Rotor allocation of one vehicle for compiled loops.

Law, signs and priorities are those of `q2q_control.attitude.allocation`; a test compares the two.
"""

import numpy as np

from q2q_control.attitude.allocation import RotorFrame
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

Numbers = Array | tuple[float, ...]
Four = tuple[float, float, float, float]


def packed_frame(frame: RotorFrame) -> Array:
    """Return lever [m], drag [m], rotor_max [N], (3,): the `frame` of `allocate`."""
    return np.array([frame.lever, frame.drag, frame.rotor_max])


@compiled
def unlimited_rotors(wrench: Numbers, frame: Numbers) -> tuple[Four, bool]:
    """Return the rotor thrusts [N] of `wrench` without limits, and whether they are within them."""
    roll, pitch = 0.25 * wrench[1] / frame[0], 0.25 * wrench[2] / frame[0]
    yaw = 0.25 * wrench[3] / frame[1]
    collective = 0.25 * wrench[0]
    most = abs(roll) + abs(pitch) + abs(yaw)
    fits = (most <= collective) & (collective <= frame[2] - most)  # no branch, so that loops of it vectorise
    one, two = -roll - pitch - yaw + collective, -roll + pitch + yaw + collective
    return (one, two, roll + pitch - yaw + collective, roll - pitch + yaw + collective), fits


@compiled
def allocate(wrench: Numbers, frame: Numbers, attitude_first: bool, rotors: Array) -> None:
    """Write the rotor thrusts [N] of `wrench` (4,) into `rotors` (4,); `frame` is `packed_frame`'s (3,)."""
    (rotors[0], rotors[1], rotors[2], rotors[3]), fits = unlimited_rotors(wrench, frame)
    if fits:
        return
    top, collective = frame[2], 0.25 * wrench[0]
    roll, pitch = 0.25 * wrench[1] / frame[0], 0.25 * wrench[2] / frame[0]
    yaw = 0.25 * wrench[3] / frame[1]
    if attitude_first:
        spread = 2.0 * (abs(roll) + abs(pitch))  # highest rotor minus lowest
        if spread > top:
            roll, pitch = roll * top / spread, pitch * top / spread
    else:
        collective = min(max(collective, 0.0), top)
        half = abs(roll) + abs(pitch)
        room = min(collective, top - collective)
        if half > room:
            roll, pitch = roll * room / half, pitch * room / half
    rotors[0], rotors[1] = -roll - pitch, -roll + pitch
    rotors[2], rotors[3] = roll + pitch, roll - pitch
    if attitude_first:
        _yaw_by_spread(rotors, yaw, top)
        low, high = -_lowest(rotors), top - _highest(rotors)
        collective = min(max(collective, low), max(low, high))
        for k in range(4):
            rotors[k] += collective
        return
    for k in range(4):
        rotors[k] += collective
    _yaw_in_box(rotors, yaw, top)


@compiled
def _yaw_by_spread(rotors: Array, yaw: float, top: float) -> None:
    # rotors 2 and 4 rise with yaw, 1 and 3 fall: the pair that meets the limit first decides
    share = 1.0
    for rising in (1, 3):
        for falling in (0, 2):
            gap = rotors[rising] - rotors[falling]
            signed = gap if yaw > 0.0 else -gap
            if abs(2.0 * yaw) * share > max(top - signed, 0.0):
                share = max(top - signed, 0.0) / abs(2.0 * yaw)
    _add_yaw(rotors, share * yaw)


@compiled
def _yaw_in_box(rotors: Array, yaw: float, top: float) -> None:
    share = 1.0
    for k in range(4):
        step = yaw if k % 2 == 1 else -yaw
        room = top - rotors[k] if step > 0.0 else rotors[k]
        if abs(step) * share > max(room, 0.0):  # rounding may leave a rotor slightly beyond its limit
            share = max(room, 0.0) / abs(step)
    _add_yaw(rotors, share * yaw)


@compiled
def _add_yaw(rotors: Array, yaw: float) -> None:
    rotors[0] -= yaw
    rotors[1] += yaw
    rotors[2] -= yaw
    rotors[3] += yaw


@compiled
def _lowest(rotors: Array) -> float:
    return float(min(rotors[0], rotors[1], rotors[2], rotors[3]))


@compiled
def _highest(rotors: Array) -> float:
    return float(max(rotors[0], rotors[1], rotors[2], rotors[3]))
