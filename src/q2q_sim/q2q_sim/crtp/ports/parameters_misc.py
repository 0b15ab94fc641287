"""Channel 3 of port 2: set by name, extended types, defaults, and the EEPROM.

Source: firmware: modules/src/param_logic.c.

| request | answer |
|---|---|
| 0, group, 0, name, 0, type, value | 0, group, 0, name, 0, error: 0, ENOENT, EINVAL, EACCES |
| 2, id | 2, id, extended type; NOT_FOUND |
| 7, id | 7, id, 0, extended type; ENOENT |
| 6, id | 6, id, default; NOT_FOUND |
| 8, id | 8, id, 0, default; ENOENT |
| 3, id | 3, id, 0: value stored; ENOENT |
| 4, id | 4, id, 0, default; 1, default, stored; NOT_FOUND |
| 5, id | 5, id, 0: stored value erased; ENOENT |
"""

from collections.abc import Callable

from q2q_sim.crtp.packets.fields import byte
from q2q_sim.crtp.packets.packet import MalformedError, Packet
from q2q_sim.crtp.ports.parameters import ENOENT, ID, NOT_FOUND, definition, value_in
from q2q_sim.crtp.tables.number_types import TYPES
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.parameters.parameter_table import TABLE, Definition

CHANNEL, SET_BY_NAME = 3, 0
EACCES, EINVAL = 13, 22
PERSISTENT = 1
"""The only extended type."""
_BY_NAME = {one.name: one for one in TABLE}


def serve(firmware: Firmware, packet: Packet) -> list[Packet]:
    """Return the answers to a packet."""
    command = byte(packet.data, 0)
    if command == SET_BY_NAME:
        return [packet.answer(_set_by_name(firmware, packet.data))]
    if command not in _COMMANDS:
        return []
    one = definition(packet.data, 1)
    made, refusal = _COMMANDS[command]
    body = None if one is None else made(firmware, one)
    return [packet.answer(packet.data[: 1 + ID.size] + (bytes([refusal]) if body is None else body))]


def _set_by_name(firmware: Firmware, data: bytes) -> bytes:
    parts = data[1:].split(b"\0", 2)
    if len(parts) < 3:
        raise MalformedError("set by name: must be group, 0, name, 0, type and value")
    group, name, rest = parts
    one = _BY_NAME.get(f"{group.decode('latin-1')}.{name.decode('latin-1')}")
    error = ENOENT
    if one is not None:
        error = _write(firmware, one, rest)
    return data[: 1 + len(group) + 1 + len(name) + 1] + bytes([error])


def _write(firmware: Firmware, one: Definition, rest: bytes) -> int:
    kind = TYPES[one.kind]
    if byte(rest, 0) != kind.param:
        return EINVAL
    if one.read_only:
        return EACCES
    firmware.parameters.set(one.name, value_in(kind, rest[1:]))
    return 0


def _default(firmware: Firmware, one: Definition) -> bytes | None:
    return None if one.read_only else TYPES[one.kind].packed(firmware.parameters.default(one.name))


def _default_v2(firmware: Firmware, one: Definition) -> bytes | None:
    value = _default(firmware, one)
    return None if value is None else b"\0" + value


def _extended(_: Firmware, one: Definition) -> bytes | None:
    return bytes([PERSISTENT]) if one.persistent else None


def _extended_v2(_: Firmware, one: Definition) -> bytes | None:
    return bytes([0, PERSISTENT]) if one.persistent else None


def _store(firmware: Firmware, one: Definition) -> bytes | None:
    if not one.persistent:
        return None
    firmware.uploads.stored[one.name] = firmware.parameters[one.name]
    return b"\0"


def _state(firmware: Firmware, one: Definition) -> bytes:
    default = TYPES[one.kind].packed(firmware.parameters.default(one.name))
    stored = firmware.uploads.stored.get(one.name)
    return b"\0" + default if stored is None else b"\1" + default + TYPES[one.kind].packed(stored)


def _clear(firmware: Firmware, one: Definition) -> bytes | None:
    return None if firmware.uploads.stored.pop(one.name, None) is None else b"\0"


MakeAnswer = Callable[[Firmware, Definition], bytes | None]

_COMMANDS: dict[int, tuple[MakeAnswer, int]] = {
    2: (_extended, NOT_FOUND),
    3: (_store, ENOENT),
    4: (_state, NOT_FOUND),
    5: (_clear, ENOENT),
    6: (_default, NOT_FOUND),
    7: (_extended_v2, ENOENT),
    8: (_default_v2, ENOENT),
}
"""Function for the body of each command's answer, and the error if it returns None."""
