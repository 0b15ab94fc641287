"""Rotor allocation of one vehicle for compiled loops.

Law, signs and priorities are those of `q2q_control.attitude.allocation`; a test compares the two.
"""

from q2q_control.attitude.allocation import RotorFrame
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Four

FloatSequence = Array | tuple[float, ...]


def packed_frame(frame: RotorFrame) -> tuple[float, float, float]:
    """Return lever [m], drag [m], rotor_max [N]: the `frame` of `allocate`."""
    return float(frame.lever), float(frame.drag), float(frame.rotor_max)


@compiled
def unlimited_rotors(wrench: FloatSequence, frame: FloatSequence) -> tuple[Four, bool]:
    """Return the rotor thrusts [N] of `wrench` without limits, and whether they are within them.

    `wrench` is U1 [N] and torques [N m], body, (4,); `frame` (3,) is that of `packed_frame`.
    """
    roll, pitch = 0.25 * wrench[1] / frame[0], 0.25 * wrench[2] / frame[0]
    yaw = 0.25 * wrench[3] / frame[1]
    collective = 0.25 * wrench[0]
    most = abs(roll) + abs(pitch) + abs(yaw)
    fits = (most <= collective) & (collective <= frame[2] - most)  # no branch, so that loops of it vectorise
    one, two = -roll - pitch - yaw + collective, -roll + pitch + yaw + collective
    return (one, two, roll + pitch - yaw + collective, roll - pitch + yaw + collective), fits


@compiled
def allocate(wrench: FloatSequence, frame: FloatSequence, rotors: Array) -> None:
    """Write the rotor thrusts [N] of `wrench` into `rotors` (4,); arguments as of `unlimited_rotors`."""
    (rotors[0], rotors[1], rotors[2], rotors[3]), fits = unlimited_rotors(wrench, frame)
    if fits:
        return
    top, collective = frame[2], 0.25 * wrench[0]
    roll, pitch = 0.25 * wrench[1] / frame[0], 0.25 * wrench[2] / frame[0]
    yaw = 0.25 * wrench[3] / frame[1]
    spread = 2.0 * (abs(roll) + abs(pitch))  # highest rotor minus lowest
    if spread > top:
        roll, pitch = roll * top / spread, pitch * top / spread
    rotors[0], rotors[1] = -roll - pitch, -roll + pitch
    rotors[2], rotors[3] = roll + pitch, roll - pitch
    _add_yaw(rotors, yaw, top)
    # no array methods: loops with BORROWING cannot compile them
    low = -min(rotors[0], rotors[1], rotors[2], rotors[3])
    high = top - max(rotors[0], rotors[1], rotors[2], rotors[3])
    collective = min(max(collective, low), max(low, high))
    for k in range(4):
        rotors[k] += collective


@compiled
def _add_yaw(rotors: Array, yaw: float, top: float) -> None:
    # rotors 2 and 4 rise with yaw, 1 and 3 fall: the pair that meets the limit first decides
    share = 1.0
    for rising in (1, 3):
        for falling in (0, 2):
            gap = rotors[rising] - rotors[falling]
            margin = max(top - (gap if yaw > 0.0 else -gap), 0.0)
            if abs(2.0 * yaw) * share > margin:
                share = margin / abs(2.0 * yaw)
    rotors[0] -= share * yaw
    rotors[1] += share * yaw
    rotors[2] -= share * yaw
    rotors[3] += share * yaw
