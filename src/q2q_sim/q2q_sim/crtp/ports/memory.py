"""Port 4: memories for the high-level commander's trajectories (0) and of the EEPROM (1).

Source: firmware: modules/src/crtp_mem.c, crtp_commander_high_level.c, drivers/src/eeprom.c.

| channel | request | answer |
|---|---|---|
| 0 | 1 | 1, number of memories |
| 0 | 2, memory | 2, memory, type, size uint32, 8 bytes of serial number; 2, memory for an unknown one |
| 1 read | memory, address uint32, length | memory, address, 0, bytes; memory, address, EIO |
| 2 write | memory, address uint32, bytes | memory, address, 0; EIO |
"""

import struct

from q2q_sim.crtp.packets.fields import byte, read_fields
from q2q_sim.crtp.packets.packet import MAX_DATA, Packet
from q2q_sim.firmware.firmware import Firmware

INFO, READ, WRITE = 0, 1, 2
TRAJECTORY_MEMORY = 0
COUNT, DETAILS = 1, 2
TRAJECTORY_TYPE, EEPROM_TYPE = 0x12, 0x00
"""MEM_TYPE_TRAJ, MEM_TYPE_EEPROM."""
EIO = 5
_PLACE, _LENGTH = struct.Struct("<BI"), struct.Struct("<BIB")
_DETAILS = struct.Struct("<BBBI8s")


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Return the answers to a packet."""
    if packet.channel == INFO:
        return _info(firmware, packet)
    if packet.channel not in {READ, WRITE}:
        return []
    said = (_read if packet.channel == READ else _write)(firmware, packet.data)
    return [packet.answer(packet.data[: _PLACE.size] + said)]


def _read(firmware: Firmware, data: bytes) -> bytes:
    memory, at, length = (int(one) for one in read_fields(_LENGTH, data))
    stored = _stored(firmware, memory)[at : at + length]
    known = len(stored) == length <= MAX_DATA - _PLACE.size - 1
    return b"\0" + bytes(stored) if known else bytes([EIO])


def _write(firmware: Firmware, data: bytes) -> bytes:
    memory, at = (int(one) for one in read_fields(_PLACE, data))
    written, stored = data[_PLACE.size :], _stored(firmware, memory)
    if at + len(written) > len(stored):
        return bytes([EIO])
    stored[at : at + len(written)] = written
    if memory == TRAJECTORY_MEMORY:
        firmware.uploads.written[at : at + len(written)] = b"\1" * len(written)
    return b"\0"


def _memories(firmware: Firmware) -> tuple[tuple[int, bytearray], ...]:
    """Return type and bytes of each memory."""
    return (TRAJECTORY_TYPE, firmware.uploads.memory), (EEPROM_TYPE, firmware.uploads.eeprom)


def _stored(firmware: Firmware, memory: int) -> bytearray:
    """Return the bytes of a memory; none of one that there is not."""
    memories = _memories(firmware)
    return memories[memory][1] if memory < len(memories) else bytearray()


def _info(firmware: Firmware, packet: Packet) -> list[Packet]:
    command, memories = byte(packet.data, 0), _memories(firmware)
    if command == COUNT:
        return [packet.answer(bytes([COUNT, len(memories)]))]
    if command != DETAILS:
        return []
    memory = byte(packet.data, 1)
    if memory >= len(memories):
        return [packet.answer(bytes([DETAILS, memory]))]
    kind, stored = memories[memory]
    return [packet.answer(_DETAILS.pack(DETAILS, memory, kind, len(stored), bytes(8)))]
