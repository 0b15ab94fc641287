r"""Binary logs of the Crazyflie's micro-SD deck, both formats that its firmware has written.

Until 2020: u8 number of variables, `name(type),` for each, CRC; then blocks: u8 number of rows, rows, CRC.
A variable `tick` [us] is the time.

Version 1 and 2: 0xBC, u16 version, u16 number of event types; for each: u16 id, `name\0`, u16 number of
variables, `name(type)\0` for each; then events: u16 id, stamp (version 1: u32 in ms, 2: u64 in us), values;
at the end the CRC of all.

All is little endian; a type is a letter of Python's `struct`; a CRC is the CRC-32 of zlib.
Source: firmware: modules/src/deck/drivers/usddeck.c; Bitcraze: On-board data logging with the micro SD card.
"""

import re
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from q2q_model.counted import counted
from q2q_model.flights.tables.column_map import FIRMWARE, ColumnMap
from q2q_model.flights.tables.table_vehicles import AXES
from q2q_model.flights.tables.usd_stamps import rising_rows, stamped_times
from q2q_model.signals.values import Array

MAGIC = 0xBC
GOOD_CRC = 0xFFFFFFFF
"""CRC-32 of bytes followed by their own inverted CRC-32, as the old format stores it."""
VARIABLE = re.compile(rb"([\w.]+)\(([bBhHiIqQefd])\)")
STAMPS = {1: ("<u4", 1e-3), 2: ("<u8", 1e-6)}
"""Version -> type of an event's stamp, and its unit [s]."""
TICK_S = 1e-6
"""Unit of `tick` in the old format [s]."""


class UsdLogError(ValueError):
    """File that is no log of a micro-SD deck, or one without a readable row."""


@dataclass(frozen=True, slots=True)
class UsdLog:
    """Rows of one vehicle's log, in the units of the firmware's variables."""

    t: Array
    """Time since the vehicle's own start of the clock [s], rising, (T,)."""
    variables: Mapping[str, Array]
    """Name as the firmware has it, such as stateEstimate.x -> values, (T,)."""
    repairs: tuple[str, ...]
    """What was left out to read the log, in words."""
    unread: tuple[str, ...] = ()
    """Event types that are not read, in words."""


def is_usd_log(data: bytes) -> bool:
    """Return whether bytes begin as a log does."""
    return data[:1] == bytes([MAGIC]) or bool(data and VARIABLE.match(data, 1))


def usd_log(data: bytes, sources: ColumnMap = FIRMWARE) -> UsdLog:
    """Return the rows of a log, with several event types those of the one that has positions.

    Rows of a block with a wrong CRC, rows cut off at the end, and rows whose time is damaged or does not rise
    are left out.

    Args:
        data: Bytes of the file.
        sources: Variables of positions. Of several event types with them, or if none has, that with most rows
            is read.

    Raises:
        UsdLogError: the bytes are no log, or no row can be read.
    """
    if not is_usd_log(data):
        raise UsdLogError("it does not begin like a log of a micro-SD deck")
    try:
        t, rows, repairs, unread = _events(data, sources) if data[0] == MAGIC else _blocks(data)
    except (struct.error, ValueError, IndexError) as damage:
        raise UsdLogError(f"its header is damaged: {damage}") from damage
    rising = rising_rows(t)
    if len(rising) < len(t):
        repairs.append(f"{counted(len(t) - len(rising), 'row')} whose time does not increase or is damaged")
    if not len(rising):
        raise UsdLogError("it has no rows")
    names = [name for name in rows.dtype.names or () if name != "tick"]
    values = {name: np.asarray(rows[name][rising], dtype=np.float64) for name in names}
    return UsdLog(t[rising], values, tuple(repairs), unread)


class _Records(NamedTuple):
    """Rows of a log as they are stored."""

    t: Array
    rows: NDArray[np.void]
    repairs: list[str]
    unread: tuple[str, ...] = ()


def _blocks(data: bytes) -> _Records:
    """Return the rows of the old format."""
    at, fields = 1, []
    for _ in range(data[0]):
        end = data.index(b",", at)
        fields.append(_field(data[at:end]))
        at = end + 1
    at += 4
    if crc32(data[:at]) != GOOD_CRC:
        raise ValueError("wrong CRC")
    kind, found, repairs = np.dtype(fields), [], []
    while at < len(data):
        end = at + 1 + data[at] * kind.itemsize + 4
        if end > len(data):
            repairs.append(f"{counted(len(data) - at, 'byte')} of a block that was cut off")
        elif crc32(data[at:end]) != GOOD_CRC:
            repairs.append(f"{counted(data[at], 'row')} of a block with a wrong CRC")
        else:
            found.append(np.frombuffer(data[at + 1 : end - 4], kind))
        at = end
    rows = np.concatenate([np.empty(0, kind), *found])
    if "tick" not in (kind.names or ()):
        raise ValueError("there is no variable tick")
    return _Records(stamped_times(rows["tick"], TICK_S), rows, repairs)


@dataclass(frozen=True, slots=True)
class _EventType:
    """Type of events in versions 1 and 2."""

    name: str
    row: np.dtype
    """Event id, stamp and variables."""

    def has_positions(self, sources: ColumnMap) -> bool:
        """Return whether its variables include a source of each of x, y, z."""
        present = self.row.names or ()
        return all(any(one.name in present for one in sources.get(axis, ())) for axis in AXES)


def _events(data: bytes, sources: ColumnMap) -> _Records:
    """Return the rows of version 1 or 2: those of one event type."""
    version, count = struct.unpack_from("<HH", data, 1)
    if version not in STAMPS:
        raise ValueError(f"version {version}; must be 1 or 2")
    stamp, unit = STAMPS[version]
    kinds, at = {}, 5
    for _ in range(count):
        (key,) = struct.unpack_from("<H", data, at)
        name, at = _text(data, at + 2)
        (variables,) = struct.unpack_from("<H", data, at)
        at, fields = at + 2, [("event id", "<u2"), ("stamp", stamp)]
        for _ in range(variables):
            text, at = _text(data, at)
            fields.append(_field(text))
        kinds[key] = _EventType(name.decode(errors="replace"), np.dtype(fields))
    if not kinds:
        raise ValueError("no event type")
    sound = crc32(data[:-4]) == int.from_bytes(data[-4:], "little")
    repairs = [] if sound else ["the CRC of the file is wrong: its end may be missing"]
    found: dict[int, list[bytes]] = {key: [] for key in kinds}
    for key, row in _rows_of_events(data[at : len(data) - 4], kinds, repairs):
        found[key].append(row)
    chosen = max(
        kinds, key=lambda key: (bool(found[key]) and kinds[key].has_positions(sources), len(found[key]))
    )
    unread = tuple(
        f"{kind.name} ({counted(len(found[key]), 'row')})"
        for key, kind in kinds.items()
        if key != chosen and found[key]
    )
    rows = np.frombuffer(b"".join(found[chosen]), kinds[chosen].row)
    kept = [name for name in rows.dtype.names or () if name not in {"event id", "stamp"}]
    return _Records(stamped_times(rows["stamp"], unit), rows[kept], repairs, unread)


def _rows_of_events(
    data: bytes, kinds: Mapping[int, _EventType], repairs: list[str]
) -> Iterator[tuple[int, bytes]]:
    at = 0
    while at + 2 <= len(data):
        key = int.from_bytes(data[at : at + 2], "little")
        end = at + kinds[key].row.itemsize if key in kinds else len(data) + 1
        if end > len(data):
            repairs.append(f"{counted(len(data) - at, 'byte')} at the end without an event")
            return
        yield key, data[at:end]
        at = end


def _text(data: bytes, at: int) -> tuple[bytes, int]:
    end = data.index(b"\0", at)
    return data[at:end], end + 1


def _field(text: bytes) -> tuple[str, str]:
    match = VARIABLE.fullmatch(text.strip())
    if match is None:
        raise ValueError(f"{text[:40]!r} is not a variable with its type")
    return match[1].decode(), f"<{match[2].decode()}"
