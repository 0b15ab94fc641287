"""A micro-SD log of a vehicle that flies along a line."""

import struct
from zlib import crc32


def log_of_a_line(first_us: int = 0) -> bytes:
    """Return a micro-SD log of 2 s along x at 1 m/s."""
    variables = [f"stateEstimate.{axis}(f)" for axis in "xyz"]
    header = struct.pack("<BHHH", 0xBC, 2, 1, 0) + b"rows\0" + struct.pack("<H", 3)
    header += b"".join(one.encode() + b"\0" for one in variables)
    rows = b"".join(struct.pack("<HQfff", 0, first_us + 10_000 * k, 0.01 * k, 0.0, 1.0) for k in range(200))
    return header + rows + struct.pack("<I", crc32(header + rows))
