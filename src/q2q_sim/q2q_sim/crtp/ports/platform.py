"""Port 13: versions and the old arming.

Source: firmware: modules/src/platformservice.c; protocol 12: modules/interface/crtp.h.

| channel | request | answer |
|---|---|---|
| 0 | 1, arm | 1, done, armed |
| 0 | 2: recover from a crash | 2, done, recovered |
| 0 | 3, kind: notify the user | the same |
| 1 | 0 | 0, protocol version int32 |
| 1 | 1; 2 | the same, then the firmware's version; the vehicle's name |
"""

from q2q_sim.crtp.packets.fields import byte
from q2q_sim.crtp.packets.packet import Packet
from q2q_sim.firmware.firmware import Firmware

PROTOCOL_VERSION = 12
COMMAND, VERSION = 0, 1
ARM, RECOVER, NOTIFY = 1, 2, 3
PROTOCOL, FIRMWARE, DEVICE = 0, 1, 2
RELEASE, NAME = b"2026.08 q2q", b"Crazyflie 2.0"


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Answer a packet on port 13."""
    command = byte(packet.data, 0)
    body = None
    if packet.channel == COMMAND:
        body = _command(firmware, command, packet.data)
    elif packet.channel == VERSION:
        versions = {PROTOCOL: PROTOCOL_VERSION.to_bytes(4, "little"), FIRMWARE: RELEASE, DEVICE: NAME}
        body = versions.get(command)
    return [] if body is None else [packet.answer(bytes([command]) + body)]


def _command(firmware: Firmware, command: int, data: bytes) -> bytes | None:
    one = firmware.supervisor
    if command == ARM:
        done = len(data) > 1 and one.request_arming(arm=bool(data[1]))
        return bytes([done, one.armed])
    if command == RECOVER:
        done = one.recover()
        return bytes([done, not one.crashed])
    return data[1:] if command == NOTIFY else None
