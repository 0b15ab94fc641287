"""Uploads of clients: trajectories in memory, parameters in the EEPROM."""

from dataclasses import dataclass, field

TRAJECTORY_BYTES = 4096
"""TRAJECTORY_MEMORY_SIZE of the firmware."""


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
    """Trajectories and persistent parameters of a vehicle."""

    memory: bytearray = field(default_factory=lambda: bytearray(TRAJECTORY_BYTES))
    defined: dict[int, Uploaded] = field(default_factory=dict)
    """By trajectory id."""
    stored: dict[str, float | int] = field(default_factory=dict)
    """Persistent parameters in the EEPROM."""
