"""Packets of Crazyswarm2's server (crazyflie_cpp: crtp.h), to the ports of q2q_sim.crtp.

| call | packet |
|---|---|
| takeoff, land | port 8, commands 1 and 2, which also turn the vehicle to yaw 0 |
| goTo, startTrajectory | commands 4 and 5 |
| cmdFullState | port 7, type 6: mm, mm/s, mm/s^2, mrad/s in 16 bits, quaternion in 32 |
| cmdPosition | type 7, whose yaw the firmware reads in degrees; the call says radians |
| cmdHover | type 5: yaw rate to the right [deg/s] |
| emergency | port 6, channel 1, type 3 |
| arm | port 13 |

The quaternion of cmdFullState is what crazyflie_py makes of the yaw: `rowan.from_euler(0, 0, yaw)`, which in
rowan's default order of z, y, x is a rotation about x. The firmware takes the yaw of that, which is 0: the
vehicle does not turn.
"""

import math
import struct
from collections.abc import Iterator, Sequence

import numpy as np

from q2q_model.geometry.quaternion32 import compress_quat
from q2q_model.signals.values import Array, Three
from q2q_sim.crtp.packets.packet import Packet, Port
from q2q_sim.crtp.ports import (
    commander_generic,
    commander_high_level,
    localization,
    log_blocks,
    memory,
    parameters,
    parameters_misc,
    platform,
)
from q2q_sim.crtp.ports.commander_high_level import HighLevel
from q2q_sim.crtp.tables.number_types import TYPES
from q2q_sim.firmware.parameters.parameter_table import Definition

TAKE_OFF, LAND = HighLevel.OLD_TAKE_OFF, HighLevel.OLD_LAND
FULL_STATE, POSITION, HOVER = 6, 7, 5
WRITE_BYTES = 24
"""Bytes of one packet that writes into the memory."""
_INT16 = TYPES["int16"]


def vertical(command: int, height: float, duration: float, mask: int) -> Packet:
    """Return a take-off or landing to a height [m] in a duration [s]."""
    return _high_level(struct.pack("<BBff", command, mask, height, duration))


def go_to(pos: Three, yaw: float, duration: float, *, relative: bool, mask: int) -> Packet:
    """Return a go-to to a position [m] and yaw [rad] in a duration [s]."""
    return _high_level(struct.pack("<BBB5f", HighLevel.GO_TO, mask, relative, *pos, yaw, duration))


def start(number: int, timescale: float, *, backwards: bool, relative: bool, mask: int) -> Packet:
    """Return the start of an uploaded trajectory."""
    return _high_level(struct.pack("<BBBBBf", HighLevel.START, mask, relative, backwards, number, timescale))


def upload(number: int, offset: int, pieces: Sequence[tuple[float, Array]]) -> Iterator[Packet]:
    """Yield the packets that write pieces into the memory and define a trajectory.

    Args:
        number: of the trajectory.
        offset: of its first piece in the memory [pieces].
        pieces: duration [s] and coefficients of rising powers of x, y, z, yaw, (4, 8), of each.
    """
    content = b"".join(
        np.asarray(polynomials, dtype="<f4").tobytes() + struct.pack("<f", duration)
        for duration, polynomials in pieces
    )
    begin = offset * commander_high_level.PIECE_BYTES
    for at in range(0, len(content), WRITE_BYTES):
        place = struct.pack("<BI", 0, begin + at)
        yield Packet(Port.MEMORY, memory.WRITE, place + content[at : at + WRITE_BYTES])
    where = commander_high_level.IN_MEMORY, commander_high_level.POLY4D, begin, len(pieces)
    yield _high_level(struct.pack("<BBBBIB", HighLevel.DEFINE, number, *where))


def full_state(pos: Three, vel: Three, acc: Three, yaw: float, omega: Three) -> Packet:
    """Return a full-state setpoint: [m], [m/s], [m/s^2], world; [rad]; [rad/s], body."""
    half = 0.5 * yaw
    quat = compress_quat((math.sin(half), 0.0, 0.0, math.cos(half)))
    numbers = b"".join(map(_milli, (*pos, *vel, *acc)))
    rates = b"".join(map(_milli, omega))
    return _setpoint(FULL_STATE, numbers + struct.pack("<I", quat) + rates)


def position(pos: Three, yaw: float) -> Packet:
    """Return a position setpoint [m] with the yaw as given."""
    return _setpoint(POSITION, struct.pack("<4f", *pos, yaw))


def hover(vx: float, vy: float, yaw_rate: float, height: float) -> Packet:
    """Return a hover setpoint: forward and left [m/s], yaw rate to the left [rad/s], height [m]."""
    return _setpoint(HOVER, struct.pack("<4f", vx, vy, -math.degrees(yaw_rate), height))


def setpoints_stop(remain_ms: int) -> Packet:
    """Return the notification that setpoints stop."""
    return Packet(
        Port.GENERIC, commander_generic.META, struct.pack("<BI", commander_generic.NOTIFY_STOP, remain_ms)
    )


def arming(*, arm: bool) -> Packet:
    """Return a request to arm or disarm."""
    return Packet(Port.PLATFORM, platform.COMMAND, bytes([platform.ARM, arm]))


def emergency() -> Packet:
    """Return the emergency stop."""
    return Packet(Port.LOCALIZATION, localization.GENERIC, bytes([localization.EMERGENCY_STOP]))


def parameter_write(number: int, one: Definition, value: float) -> Packet:
    """Return a new value of a parameter."""
    return Packet(Port.PARAM, parameters.WRITE, struct.pack("<H", number) + TYPES[one.kind].packed(value))


def parameter_write_by_name(one: Definition, value: float) -> Packet:
    """Return a new value of a parameter, for all vehicles."""
    kind = TYPES[one.kind]
    names = f"{one.group}\0{one.last}\0".encode("latin-1")
    data = bytes([parameters_misc.SET_BY_NAME]) + names + bytes([kind.param or 0]) + kind.packed(value)
    return Packet(Port.PARAM, parameters_misc.CHANNEL, data)


def log_packets(block: int, variables: Sequence[tuple[int, int]], frequency: int) -> tuple[Packet, Packet]:
    """Return the creation and the start of a log block.

    Args:
        block: its number.
        variables: type code and number of each.
        frequency: [Hz]
    """
    content = b"".join(struct.pack("<BH", kind, number) for kind, number in variables)
    made = Packet(Port.LOG, log_blocks.CONTROL, bytes([log_blocks.CREATE, block]) + content)
    period = int(100 / frequency) & 0xFF  # uint8 of 10 ms
    return made, Packet(Port.LOG, log_blocks.CONTROL, bytes([log_blocks.START, block, period]))


def _high_level(data: bytes) -> Packet:
    return Packet(Port.HIGH_LEVEL, 0, data)


def _setpoint(kind: int, data: bytes) -> Packet:
    return Packet(Port.GENERIC, commander_generic.SETPOINT, bytes([kind]) + data)


def _milli(value: float) -> bytes:
    """Return a float32 times 1000 in 16 bits, towards zero and modulo the width."""
    return _INT16.packed(float(np.float32(1000.0) * np.float32(value)))
