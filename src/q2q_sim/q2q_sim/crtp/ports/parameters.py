"""Port 2: parameter table, values by number and by name.

Source: firmware: modules/src/param_task.c, param_logic.c.

| channel | request | answer |
|---|---|---|
| 0 table | toc.py | |
| 1 read | id uint16 | id, 0, value; id, ENOENT |
| 2 write | id uint16, value | the same; id, 2 for an unknown id; none for a read-only one |
| 3 misc | parameters_misc.py | |

A short or NaN value is refused without an answer, as is a write of a read-only parameter.
"""

import struct

from q2q_sim.crtp.packets.fields import read_fields
from q2q_sim.crtp.packets.packet import Packet
from q2q_sim.crtp.tables.number_types import TYPES, NumberType
from q2q_sim.crtp.tables.param_toc import PARAM_TOC
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.parameters.parameter_table import TABLE, Definition, FirmwareValue

TOC, READ, WRITE = 0, 1, 2
ENOENT = 2
NOT_FOUND = 2
"""PARAM_NOT_FOUND."""
ID = struct.Struct("<H")


def definition(data: bytes, at: int = 0) -> Definition | None:
    """Return the parameter whose id is at `at` in `data`; None if unknown."""
    number = int(read_fields(ID, data, at)[0])
    return TABLE[number] if number < len(TABLE) else None


def packed_value(firmware: Firmware, one: Definition) -> bytes:
    """Return a parameter's value as bytes."""
    return TYPES[one.kind].packed(firmware.parameters[one.name])


def value_in(kind: NumberType, data: bytes) -> FirmwareValue:
    """Return the value at the front of `data`; raise MalformedError if it is short or not finite."""
    value = read_fields(kind.layout, data)[0]
    return int(value) if kind.integer else value


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Return the answers to a packet on channels 0, 1 or 2."""
    if packet.channel == TOC:
        listed = PARAM_TOC.answer(packet.data)
        return [] if listed is None else [packet.answer(listed)]
    one = definition(packet.data)
    number = packet.data[: ID.size]
    if packet.channel == READ:
        value = bytes([ENOENT]) if one is None else b"\0" + packed_value(firmware, one)
        return [packet.answer(number + value)]
    if one is None:
        return [packet.answer(number + bytes([NOT_FOUND]))]
    if one.read_only:
        return []
    firmware.parameters.set(one.name, value_in(TYPES[one.kind], packet.data[ID.size :]))
    return [packet]
