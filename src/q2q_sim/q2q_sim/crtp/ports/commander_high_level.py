"""Port 8: take-off, landing, go-to, spirals and uploaded trajectories.

Source: firmware: modules/src/crtp_commander_high_level.c. The answer is the request's first three bytes and
the result (firmware.commander.planner.PlannerResult). Commands carry a group mask: 0 is everyone, else the
vehicle obeys if hlCommander.groupmask shares a bit. Yaw is in radians here, heights are in the world frame.

| command | fields after it |
|---|---|
| 0 set group mask | mask |
| 1, 2 take off, land (old) | mask, height, duration |
| 3 stop | mask: motors off |
| 4, 12 go to | mask, relative, (12: linear,) x, y, z, yaw, duration |
| 5, 13 start trajectory | mask, relative position, (13: relative yaw,) reversed, id, time scale |
| 6 define trajectory | id, location 1, type 0 or 1 (compressed), offset uint32, pieces |
| 7, 8 take off, land | mask, height, yaw, keep the present yaw, duration |
| 9, 10 the same | mask, height, relative, yaw, keep, velocity |
| 11 spiral | mask, sideways, clockwise, angle, first and last radius, ascent, duration |

Durations are not checked, and a trajectory that is not defined is answered OK and not flown. A compressed one
is never rotated, and answered UNKNOWN if it is to be reversed or stretched. Unlike in the firmware,
trajectories without pieces and those that leave the memory are answered UNKNOWN.
"""

import struct
from collections.abc import Callable
from enum import IntEnum

import numpy as np

from q2q_sim.crtp.packets.fields import byte, read_fields
from q2q_sim.crtp.packets.packet import Packet
from q2q_sim.firmware.commander.compressed_pieces import compressed_bytes, compressed_pieces
from q2q_sim.firmware.commander.piecewise import Piecewise, StoredBytes
from q2q_sim.firmware.commander.planner import Begin, PlannerResult, Target, Vertical
from q2q_sim.firmware.commander.polynomial import Piece
from q2q_sim.firmware.commander.spiral import Spiral, spiral_piece
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.parameters.uploads import TRAJECTORY_BYTES, Uploaded

OLD_VERTICAL, VERTICAL, _SPEED = struct.Struct("<Bff"), struct.Struct("<Bff?f"), struct.Struct("<Bf?f?f")
GO, GO_2, _ARC = struct.Struct("<BB5f"), struct.Struct("<BBB5f"), struct.Struct("<BBB5f")
_START, _START_2, _DEFINE = struct.Struct("<BBBBf"), struct.Struct("<BBBBBf"), struct.Struct("<BBBIB")
PIECE_BYTES = 132
"""4 polynomials of 8 floats and a duration."""
IN_MEMORY, POLY4D, COMPRESSED = 1, 0, 1
TRAJECTORIES = 31
"""NUM_TRAJECTORY_DEFINITIONS."""


class HighLevel(IntEnum):
    """Commands by their numbers."""

    SET_MASK = 0
    OLD_TAKE_OFF = 1
    OLD_LAND = 2
    STOP = 3
    GO_TO = 4
    START = 5
    DEFINE = 6
    TAKE_OFF = 7
    LAND = 8
    TAKE_OFF_AT_SPEED = 9
    LAND_AT_SPEED = 10
    SPIRAL = 11
    GO_TO_2 = 12
    START_2 = 13


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Execute a command and return the answer."""
    command = byte(packet.data, 0)
    rest = packet.data[1:]
    answer = _COMMANDS[command](firmware, rest) if command in _COMMANDS else PlannerResult.UNKNOWN
    return [packet.answer(packet.data[:3].ljust(3, b"\0") + bytes([answer]))]


def _addressed(firmware: Firmware, mask: float) -> bool:
    return mask == 0 or bool(int(mask) & int(firmware.parameters["hlCommander.groupmask"]))


def _flying(act: Callable[[Firmware, bytes], PlannerResult]) -> Callable[[Firmware, bytes], PlannerResult]:
    """Return `act` if the supervisor permits flight and the command is for the vehicle's group."""

    def guarded(firmware: Firmware, data: bytes) -> PlannerResult:
        if not firmware.supervisor.may_fly:
            return PlannerResult.BLOCKED
        return act(firmware, data) if _addressed(firmware, byte(data, 0)) else PlannerResult.OK

    return guarded


def _set_mask(firmware: Firmware, data: bytes) -> PlannerResult:
    firmware.parameters.set("hlCommander.groupmask", byte(data, 0))
    return PlannerResult.OK


def _stop(firmware: Firmware, data: bytes) -> PlannerResult:
    return firmware.planner.stop() if _addressed(firmware, byte(data, 0)) else PlannerResult.OK


def _vertical(data: bytes) -> Vertical:
    _, height, yaw, keep, duration = read_fields(VERTICAL, data)
    return Vertical(height, duration, None if keep else yaw)


def _old_vertical(data: bytes) -> Vertical:
    _, height, duration = read_fields(OLD_VERTICAL, data)
    return Vertical(height, duration, 0.0)


def _at_speed(firmware: Firmware, data: bytes, name: str, up: float) -> Vertical:
    _, height, relative, yaw, keep, speed = read_fields(_SPEED, data)
    now = float(firmware.planner.here.pos[2])
    end = now + up * height if relative else height
    pace = speed if speed > 0.0 else float(firmware.parameters[f"hlCommander.{name}"])
    with np.errstate(all="ignore"):  # a speed of 0 takes for ever
        duration = float(np.float64(abs(end - now)) / pace)
    return Vertical(end, duration, None if keep else yaw)


def _go(firmware: Firmware, data: bytes) -> PlannerResult:
    _, relative, x, y, z, yaw, duration = read_fields(GO, data)
    target = Target((x, y, z), yaw, duration, relative=bool(relative))
    return firmware.planner.go_to(target, firmware.seconds)


def _go_2(firmware: Firmware, data: bytes) -> PlannerResult:
    _, relative, linear, x, y, z, yaw, duration = read_fields(GO_2, data)
    target = Target((x, y, z), yaw, duration, relative=bool(relative), linear=bool(linear))
    return firmware.planner.go_to(target, firmware.seconds)


def _arc(firmware: Firmware, data: bytes) -> PlannerResult:
    _, sideways, clockwise, angle, first, last, ascent, duration = read_fields(_ARC, data)
    spiral = Spiral(angle, first, last, ascent, duration, bool(sideways), bool(clockwise))
    return firmware.planner.fly_piece(spiral_piece(firmware.planner.here, spiral), firmware.seconds)


def _define(firmware: Firmware, data: bytes) -> PlannerResult:
    number, location, kind, offset, pieces = (int(one) for one in read_fields(_DEFINE, data))
    if number >= TRAJECTORIES:
        return PlannerResult.UNKNOWN
    firmware.uploads.defined[number] = Uploaded(location, kind, offset, pieces)
    return PlannerResult.OK


def _start(firmware: Firmware, data: bytes) -> PlannerResult:
    _, relative, backwards, number, scale = read_fields(_START, data)
    begin = Begin.HERE if relative else Begin.AS_WRITTEN
    return _follow(firmware, int(number), scale, begin, backwards=bool(backwards))


def _start_2(firmware: Firmware, data: bytes) -> PlannerResult:
    _, relative, turned, backwards, number, scale = read_fields(_START_2, data)
    here = Begin.HERE_TURNED if turned else Begin.HERE
    begin = here if relative else Begin.AS_WRITTEN
    return _follow(firmware, int(number), scale, begin, backwards=bool(backwards))


def _follow(firmware: Firmware, number: int, scale: float, begin: Begin, *, backwards: bool) -> PlannerResult:
    """Fly an uploaded trajectory; a compressed one is never rotated."""
    one = firmware.uploads.defined.get(number)
    if one is None or one.location != IN_MEMORY or one.kind not in {POLY4D, COMPRESSED}:
        return PlannerResult.OK
    compressed = one.kind == COMPRESSED
    pieces = () if compressed and (scale != 1.0 or backwards) else _uploaded(firmware.uploads.memory, one)
    if not pieces:
        return PlannerResult.UNKNOWN
    place = _stored(firmware.uploads.memory, one)
    stored = StoredBytes(place, bytes(firmware.uploads.memory[place.start : place.stop]))
    trajectory = Piecewise(pieces, firmware.seconds, scale, backwards=backwards, stored=stored)
    begin = Begin.HERE if compressed and begin is Begin.HERE_TURNED else begin
    return firmware.planner.follow(trajectory, begin)


def _uploaded(memory: bytearray, one: Uploaded) -> tuple[Piece, ...]:
    """Return the pieces of an uploaded trajectory; none if it leaves the memory."""
    if one.kind == COMPRESSED:
        try:
            return compressed_pieces(memory, one.offset)
        except ValueError:
            return ()
    stored = _stored(memory, one)
    if stored.stop > TRAJECTORY_BYTES:
        return ()
    return tuple(_piece(memory, at) for at in stored[::PIECE_BYTES])


def _stored(memory: bytearray, one: Uploaded) -> range:
    """Return the bytes of an uploaded trajectory, which may leave the memory unless it is compressed."""
    if one.kind == COMPRESSED:
        return compressed_bytes(memory, one.offset)
    return range(one.offset, one.offset + one.pieces * PIECE_BYTES)


@np.errstate(all="ignore")
def _piece(memory: bytearray, at: int) -> Piece:
    """Return the uploaded piece at an offset; its bytes may be any, a signalling NaN too."""
    numbers = np.frombuffer(memory, dtype="<f4", count=PIECE_BYTES // 4, offset=at).astype(np.float64)
    return Piece(float(numbers[32]), numbers[:32].reshape(4, 8))


_COMMANDS: dict[int, Callable[[Firmware, bytes], PlannerResult]] = {
    HighLevel.SET_MASK: _set_mask,
    HighLevel.OLD_TAKE_OFF: _flying(lambda one, data: one.planner.take_off(_old_vertical(data), one.seconds)),
    HighLevel.OLD_LAND: _flying(lambda one, data: one.planner.land(_old_vertical(data), one.seconds)),
    HighLevel.STOP: _stop,
    HighLevel.GO_TO: _flying(_go),
    HighLevel.START: _flying(_start),
    HighLevel.DEFINE: _define,
    HighLevel.TAKE_OFF: _flying(lambda one, data: one.planner.take_off(_vertical(data), one.seconds)),
    HighLevel.LAND: _flying(lambda one, data: one.planner.land(_vertical(data), one.seconds)),
    HighLevel.TAKE_OFF_AT_SPEED: _flying(
        lambda one, data: one.planner.take_off(_at_speed(one, data, "vtoff", 1.0), one.seconds)
    ),
    HighLevel.LAND_AT_SPEED: _flying(
        lambda one, data: one.planner.land(_at_speed(one, data, "vland", -1.0), one.seconds)
    ),
    HighLevel.SPIRAL: _flying(_arc),
    HighLevel.GO_TO_2: _flying(_go_2),
    HighLevel.START_2: _flying(_start_2),
}
"""Function of each command."""
