"""Port 9: state of the supervisor, arming, recovery, emergency stop.

Source: firmware: modules/src/crtp_supervisor.c. Answers carry the command with its highest bit set.

| channel | request | answer |
|---|---|---|
| 0 | 1 .. 11: one bit of the state | 0 or 1 |
| 0 | 12: all bits | uint16 |
| 1 | 1, arm | done, armed |
| 1 | 2: recover from a crash | done, recovered |
| 1 | 3: emergency stop; 4: feed its watchdog | none |
"""

from q2q_sim.crtp.packets.fields import byte
from q2q_sim.crtp.packets.packet import Packet
from q2q_sim.firmware.firmware import Firmware

INFO, COMMAND = 0, 1
ALL_BITS = 12
ARM, RECOVER, STOP, FEED = 1, 2, 3, 4
RESPONSE = 0x80


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Execute a packet and return the answers."""
    command = byte(packet.data, 0)
    body = None
    if packet.channel == INFO:
        body = _info(command, firmware.info)
    elif packet.channel == COMMAND:
        body = _command(firmware, command, packet.data)
    return [] if body is None else [packet.answer(bytes([RESPONSE | command]) + body)]


def _info(command: int, bits: int) -> bytes | None:
    if command == ALL_BITS:
        return bits.to_bytes(2, "little")
    return bytes([bits >> (command - 1) & 1]) if 1 <= command < ALL_BITS else None


def _command(firmware: Firmware, command: int, data: bytes) -> bytes | None:
    one = firmware.supervisor
    if command == ARM:
        done = one.request_arming(arm=bool(byte(data, 1)))
        return bytes([done, one.armed])
    if command == RECOVER:
        done = one.recover()
        return bytes([done, not one.crashed])
    if command == STOP:
        one.stop()
    elif command == FEED:
        one.feed(firmware.now_ms)
    return None
