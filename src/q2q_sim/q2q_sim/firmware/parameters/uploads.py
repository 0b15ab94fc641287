"""Uploads of clients: trajectories in memory, parameters and the configuration in the EEPROM.

The configuration begins the EEPROM (firmware: utils/src/configblockeeprom.c, version 1); nothing reads it
here: 0xBC, version uint8, radio channel and speed uint8, trim of pitch and roll [deg], radio address (upper
uint8, lower uint32), and the sum of all bytes before.
"""

import struct
from dataclasses import dataclass, field

TRAJECTORY_BYTES = 4096
"""TRAJECTORY_MEMORY_SIZE of the firmware."""
EEPROM_BYTES = 0x1FFF
"""EEPROM_SIZE of the firmware."""
_CONFIGURATION = struct.pack("<4sBBBffBI", b"0xBC", 1, 80, 2, 0.0, 0.0, 0xE7, 0xE7E7E7E7)
"""Stock radio: channel 80, 2 Mbit/s, address E7E7E7E7E7."""


def stock_eeprom() -> bytearray:
    """Return the EEPROM of a vehicle that was never configured."""
    configured = _CONFIGURATION + bytes([sum(_CONFIGURATION) % 256])
    return bytearray(configured.ljust(EEPROM_BYTES, b"\xff"))


@dataclass(frozen=True, slots=True)
class Uploaded:
    """Description of an uploaded trajectory by its client."""

    location: int
    kind: int
    offset: int
    """First byte in the trajectory memory."""
    pieces: int


@dataclass(slots=True)
class Uploads:
    """Trajectories, configuration and persistent parameters of a vehicle."""

    memory: bytearray = field(default_factory=lambda: bytearray(TRAJECTORY_BYTES))
    written: bytearray = field(default_factory=lambda: bytearray(TRAJECTORY_BYTES))
    """1 for each byte of `memory` that a client has written, else 0."""
    eeprom: bytearray = field(default_factory=stock_eeprom)
    defined: dict[int, Uploaded] = field(default_factory=dict)
    """By trajectory id."""
    stored: dict[str, float | int] = field(default_factory=dict)
    """Persistent parameters in the EEPROM, whose bytes do not show them."""
