"""Format of serialized q2q_msgs: plain CDR, little endian (DDS-XTypes 1.3, 7.4.1).

These messages are a header, names and flat arrays only. Every number is aligned to its size, counted from the
end of the four encapsulation bytes:

    stamp: int32 s, uint32 ns | frame_id: string | names: uint32 n, n strings | per array: uint32 n, n numbers
    string: uint32 length with the closing zero byte, bytes, zero byte

Direct serialization (cdr_writer, cdr_reader) costs a tenth of conversion through message objects, which sets
the speed of lockstep. A test compares it byte for byte with rclpy and rosbags.
"""

import struct

import numpy as np

from q2q_model.signals.layout import Column
from q2q_model.signals.stamps import BadStampError, stamp_from_parts
from q2q_model.signals.values import SwarmImu

ENCAPSULATION = b"\x00\x01\x00\x00"
"""Plain CDR, little endian, no options."""
START = len(ENCAPSULATION)
NAMES_AT = START + 8
"""Offset of frame_id, after the stamp."""
WORLD, BODY = "world", "body"
COUNT = struct.Struct("<I")
STAMP = struct.Struct("<iI")


class BadMessageError(ValueError):
    """Error for a malformed or inconsistent message."""


def header_stamp_ns(data: bytes | bytearray) -> int:
    """Return the stamp [ns] of a message whose first field is std_msgs/Header."""
    if len(data) < NAMES_AT:
        raise BadMessageError(f"message has {len(data)} bytes; a header needs at least {NAMES_AT}")
    sec, nanosec = struct.unpack_from("<iI" if data[1] & 1 else ">iI", data, START)
    try:
        return stamp_from_parts(sec, nanosec)
    except BadStampError as bad:
        raise BadMessageError(str(bad)) from bad


def frame_id_of(kind: type) -> str:
    """Return the frame_id of the messages of a signal."""
    return BODY if kind is SwarmImu else WORLD


def dtype_of(column: Column) -> type[np.generic]:
    """Return the type of a column's numbers in a message."""
    return np.uint8 if column.attribute == "status" else np.float64


def aligned(at: int, size: int) -> int:
    """Return the first offset from `at` on at which a number of `size` bytes may lie."""
    return at + (START - at) % size
