"""Read the header stamp of a serialised message without decoding the rest."""

import struct

LITTLE_ENDIAN = 1
ENCAPSULATION = 4
"""Bytes before the first field of a CDR message: representation and options (DDS-XTypes 1.3, 7.6.2)."""
NANOSECONDS = 1_000_000_000


def header_stamp_ns(data: bytes) -> int:
    """Return the stamp [ns] of a message whose first field is std_msgs/Header."""
    order = "<" if data[1] == LITTLE_ENDIAN else ">"
    sec, nanosec = struct.unpack_from(f"{order}iI", data, ENCAPSULATION)
    return int(sec) * NANOSECONDS + int(nanosec)
