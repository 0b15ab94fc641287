"""Port 4: one memory, for the high-level commander's trajectories.

Source: firmware: modules/src/crtp_mem.c, crtp_commander_high_level.c.

| channel | request | answer |
|---|---|---|
| 0 | 1 | 1, number of memories |
| 0 | 2, memory | 2, memory, type, size uint32, 8 bytes of serial number; 2, memory for an unknown one |
| 1 read | memory, address uint32, length | memory, address, 0, bytes; memory, address, EIO |
| 2 write | memory, address uint32, bytes | memory, address, 0; EIO |
"""

import struct

from q2q_sim.crtp.packets.fields import byte, read
from q2q_sim.crtp.packets.packet import MAX_DATA, Packet
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.parameters.uploads import TRAJECTORY_BYTES

INFO, READ, WRITE = 0, 1, 2
COUNT, DETAILS = 1, 2
TRAJECTORY_TYPE = 0x12
"""MEM_TYPE_TRAJ."""
EIO = 5
_PLACE, _LENGTH = struct.Struct("<BI"), struct.Struct("<BIB")
_DETAILS = struct.Struct("<BBBI8s")


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Return the answers to a packet."""
    if packet.channel == INFO:
        return _info(packet)
    if packet.channel == READ:
        memory, at, length = (int(one) for one in read(_LENGTH, packet.data))
        head = packet.data[: _PLACE.size]
        if memory != 0 or at + length > TRAJECTORY_BYTES or length > MAX_DATA - _PLACE.size - 1:
            return [packet.answer(head + bytes([EIO]))]
        return [packet.answer(head + b"\0" + bytes(firmware.uploads.memory[at : at + length]))]
    if packet.channel == WRITE:
        memory, at = (int(one) for one in read(_PLACE, packet.data))
        written = packet.data[_PLACE.size :]
        fits = memory == 0 and at + len(written) <= TRAJECTORY_BYTES
        if fits:
            firmware.uploads.memory[at : at + len(written)] = written
        return [packet.answer(packet.data[: _PLACE.size] + bytes([0 if fits else EIO]))]
    return []


def _info(packet: Packet) -> list[Packet]:
    command = byte(packet.data, 0)
    if command == COUNT:
        return [packet.answer(bytes([COUNT, 1]))]
    if command != DETAILS:
        return []
    memory = byte(packet.data, 1)
    if memory != 0:
        return [packet.answer(bytes([DETAILS, memory]))]
    return [packet.answer(_DETAILS.pack(DETAILS, 0, TRAJECTORY_TYPE, TRAJECTORY_BYTES, bytes(8)))]
