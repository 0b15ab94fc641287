"""Ports 13 and 15: versions, the old arming, echo and source.

Source: firmware: modules/src/platformservice.c, crtpservice.c; protocol 12: modules/interface/crtp.h.

| port, channel | request | answer |
|---|---|---|
| 13, 0 | 1, arm | 1, done, armed |
| 13, 0 | 2: recover from a crash | 2, done, recovered |
| 13, 0 | 3, kind: tell the user | the same |
| 13, 1 | 0 | 0, protocol version int32 |
| 13, 1 | 1; 2 | the same, then the firmware's version; the vehicle's name |
| 15, 0 | any | the same |
| 15, 1 | any | "Bitcraze Crazyflie", filled to 30 bytes with 0 |
| 15, 2 | any | none |
"""

from q2q_sim.crtp.packets.fields import byte
from q2q_sim.crtp.packets.packet import MAX_DATA, Packet
from q2q_sim.firmware.firmware import Firmware

PROTOCOL_VERSION = 12
COMMAND, VERSION = 0, 1
ARM, RECOVER, NOTIFY = 1, 2, 3
PROTOCOL, FIRMWARE, DEVICE = 0, 1, 2
ECHO, SOURCE = 0, 1
RELEASE, NAME, GREETING = b"2026.08 q2q", b"Crazyflie 2.0", b"Bitcraze Crazyflie"


def serve_platform(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Answer a packet on port 13."""
    command = byte(packet.data, 0)
    body = None
    if packet.channel == COMMAND:
        body = _command(firmware, command, packet.data)
    elif packet.channel == VERSION:
        versions = {PROTOCOL: PROTOCOL_VERSION.to_bytes(4, "little"), FIRMWARE: RELEASE, DEVICE: NAME}
        body = versions.get(command)
    return [] if body is None else [packet.answer(bytes([command]) + body)]


def serve_link(packet: Packet) -> list[Packet]:
    """Answer a packet on port 15."""
    if packet.channel == ECHO:
        return [packet]
    return [packet.answer(GREETING.ljust(MAX_DATA, b"\0"))] if packet.channel == SOURCE else []


def _command(firmware: Firmware, command: int, data: bytes) -> bytes | None:
    one = firmware.supervisor
    if command == ARM:
        done = len(data) > 1 and one.request_arming(arm=bool(data[1]))
        return bytes([done, one.armed])
    if command == RECOVER:
        done = one.recover()
        return bytes([done, not one.crashed])
    return data[1:] if command == NOTIFY else None
