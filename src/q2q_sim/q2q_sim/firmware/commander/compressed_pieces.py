"""Pieces of a compressed trajectory in the trajectory memory.

Source: firmware: modules/src/pptraj_compressed.c. Little endian:

    start       x y z [mm] and yaw, int16 each
    segment     a byte of four storage types, x in the lowest two bits, then y, z, yaw; duration [ms], uint16
                (0 ends the trajectory); control points of x, then of y, z, yaw, int16 each

A storage type of 0, 1, 2 or 3 has 0, 1, 3 or 7 Bezier control points after the first one, which is the end
of the segment before. Clients send yaw in tenths of a degree; the firmware takes ten times that number for
radians (STORED_ANGLE_SCALE), and so does this.
"""

import struct

import numpy as np

from q2q_model.trajectory.bernstein import ascending_powers
from q2q_sim.firmware.commander.polynomial import ORDER, Piece, goal_at_rest, piece_between

POINTS = (0, 1, 3, 7)
"""Control points of each storage type."""
SCALE = (1e-3, 1e-3, 1e-3, 10.0)
"""Units of x, y, z [m] and yaw [rad]."""
_START, _HEAD = struct.Struct("<4h"), struct.Struct("<BH")


def compressed_pieces(memory: bytes | bytearray, at: int) -> tuple[Piece, ...]:
    """Return the pieces of the trajectory at an offset, at least one; ValueError if it leaves the memory."""
    try:
        return _pieces(memory, at)
    except struct.error as error:
        raise ValueError(f"the trajectory at byte {at} does not end within the memory") from error


def compressed_bytes(memory: bytes | bytearray, at: int) -> range:
    """Return the bytes of the trajectory at an offset, which has an end in the memory."""
    end = at + _START.size
    while True:
        types, milliseconds = _HEAD.unpack_from(memory, end)
        end += _HEAD.size
        if not milliseconds:
            return range(at, end)
        end += 2 * sum(POINTS[types >> 2 * axis & 3] for axis in range(4))


def _pieces(memory: bytes | bytearray, at: int) -> tuple[Piece, ...]:
    here = [unit * value for unit, value in zip(SCALE, _START.unpack_from(memory, at), strict=True)]
    at, start = at + _START.size, goal_at_rest(np.array(here[:3]), here[3])
    found: list[Piece] = []
    while True:
        types, milliseconds = _HEAD.unpack_from(memory, at)
        if not milliseconds:
            return tuple(found) or (piece_between(start, start, 0.0),)
        at, duration, coefficients = at + _HEAD.size, 1e-3 * milliseconds, np.zeros((4, ORDER))
        for axis in range(4):
            count = POINTS[types >> 2 * axis & 3]
            values = struct.unpack_from(f"<{count}h", memory, at)
            at += 2 * count
            points = np.array([here[axis], *(SCALE[axis] * value for value in values)])
            coefficients[axis, : count + 1] = ascending_powers(points, np.array(duration))
            here[axis] = float(points[-1])
        found.append(Piece(duration, coefficients))
