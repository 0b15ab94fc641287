"""CRTP packets as datagrams: one header byte, then up to 30 bytes.

    header = port << 4 | 3 << 2 | channel        bits 2 and 3 are set for old bootloaders

A single 0xFF is the null packet, with which clients search for vehicles (cflib: crtp/udpdriver.py).
"""

from dataclasses import dataclass
from enum import IntEnum

MAX_DATA = 30
"""Largest payload [bytes]."""
NULL = b"\xff"


class Port(IntEnum):
    """Ports of a Crazyflie."""

    CONSOLE = 0
    PARAM = 2
    SETPOINT = 3
    MEMORY = 4
    LOG = 5
    LOCALIZATION = 6
    GENERIC = 7
    HIGH_LEVEL = 8
    SUPERVISOR = 9
    PLATFORM = 13
    LINK = 15


STREAMED = frozenset((Port.SETPOINT, Port.GENERIC, Port.LOCALIZATION))
"""Ports whose packets are not retransmitted."""
LOG_DATA = 2
"""Channel of port 5 whose packets are not retransmitted."""


class MalformedError(ValueError):
    """Datagram that is not a packet, or packet that is short or invalid."""


@dataclass(frozen=True, slots=True)
class Packet:
    """One packet."""

    port: int
    channel: int
    data: bytes = b""

    def answer(self, data: bytes) -> "Packet":
        """Return an answer on the same port and channel."""
        return Packet(self.port, self.channel, data)


def packet_of(datagram: bytes) -> Packet:
    """Return the packet in a datagram; raise MalformedError if there is none."""
    if not 1 <= len(datagram) <= 1 + MAX_DATA:
        raise MalformedError(f"datagram of {len(datagram)} bytes; must be 1 to {1 + MAX_DATA}")
    return Packet(datagram[0] >> 4, datagram[0] & 0x03, datagram[1:])


def datagram_of(packet: Packet) -> bytes:
    """Return the datagram of a packet; raise ValueError if it is too long."""
    if len(packet.data) > MAX_DATA:
        raise ValueError(
            f"packet of {len(packet.data)} bytes on port {packet.port}; must be at most {MAX_DATA}"
        )
    return bytes([packet.port << 4 | 0x0C | packet.channel]) + packet.data


def is_stream(datagram: bytes) -> bool:
    """Return whether a datagram belongs to a stream."""
    port = datagram[0] >> 4
    return port in STREAMED or (port == Port.LOG and datagram[0] & 0x03 == LOG_DATA)
