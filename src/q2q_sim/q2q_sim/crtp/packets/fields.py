"""Packed fields of a packet; short packets and numbers that are not finite are refused."""

import math
from struct import Struct

from q2q_sim.crtp.packets.packet import MalformedError


def read_fields(layout: Struct, data: bytes, at: int = 0) -> tuple[float, ...]:
    """Return the numbers of a layout at `at` in `data`.

    Raises:
        MalformedError: the data end before the layout does, or a number is not finite.
    """
    if len(data) < at + layout.size:
        raise MalformedError(f"{len(data)} bytes; must be at least {at + layout.size}")
    numbers: tuple[float, ...] = layout.unpack_from(data, at)
    if not all(math.isfinite(number) for number in numbers):
        raise MalformedError(f"{numbers}; must be finite")
    return numbers


def byte(data: bytes, at: int) -> int:
    """Return one byte; raise MalformedError if the data end before it."""
    if len(data) <= at:
        raise MalformedError(f"{len(data)} bytes; must be at least {at + 1}")
    return data[at]
