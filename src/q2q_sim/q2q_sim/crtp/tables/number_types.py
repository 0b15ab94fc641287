"""The firmware's number types with their codes in both tables.

Source: firmware: modules/interface/log.h, param.h.
"""

import math
import struct
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class NumberType:
    """One number type."""

    layout: struct.Struct
    log: int | None
    """Code in log blocks; None if it cannot be logged."""
    param: int | None
    """Code in the parameter table; None if it cannot be a parameter."""
    high: float
    """Largest value."""
    integer: bool = True

    def packed(self, value: float) -> bytes:
        """Return a value as the firmware casts it: integers towards zero and modulo the width."""
        if not self.integer:
            return self.layout.pack(math.copysign(math.inf, value) if abs(value) > self.high else value)
        bits = 8 * self.layout.size
        wrapped = int(value if math.isfinite(value) else 0.0) % (1 << bits)
        return wrapped.to_bytes(self.layout.size, "little")


def _integer(code: str, log: int, param: int) -> NumberType:
    layout = struct.Struct(f"<{code}")
    bits = 8 * layout.size
    return NumberType(layout, log, param, 2.0 ** (bits if code.isupper() else bits - 1) - 1.0)


TYPES = {
    "uint8": _integer("B", 1, 0x08),
    "uint16": _integer("H", 2, 0x09),
    "uint32": _integer("I", 3, 0x0A),
    "int8": _integer("b", 4, 0x00),
    "int16": _integer("h", 5, 0x01),
    "int32": _integer("i", 6, 0x02),
    "float": NumberType(struct.Struct("<f"), 7, 0x06, 3.4028234e38, integer=False),
    "fp16": NumberType(struct.Struct("<e"), 8, None, 65504.0, integer=False),
}
"""C type to its NumberType."""

BY_LOG_NUMBER = {one.log: one for one in TYPES.values()}
"""Number in a log block to its type."""
