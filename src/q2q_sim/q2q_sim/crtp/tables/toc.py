"""Table of contents: number of entries, checksum, and each entry by number (version 2).

Source: firmware: modules/src/log.c, param_logic.c. The checksum chains CRC-32 over the entries and the groups
around them, so it changes with any name, type or order, which keeps client caches valid.

    crc' = crc32(crc, little endian | type | name)

| command | answer |
|---|---|
| 3 | 3, count uint16, crc uint32, then `extra` of the table |
| 2, number uint16 | 2, number uint16, type, group, 0, name, 0; only 2 for an unknown number |
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from zlib import crc32

from q2q_sim.crtp.packets.fields import read_fields
from q2q_sim.crtp.packets.packet import MAX_DATA

ITEM, INFO = 2, 3
_NUMBER, _COUNT_CRC, _CRC = struct.Struct("<H"), struct.Struct("<HI"), struct.Struct("<I")
_GROUP, _START = 0x80, 1


@dataclass(frozen=True, slots=True)
class TocEntry:
    """One entry."""

    group: str
    name: str
    kind: int
    """Type byte of the table."""

    def __post_init__(self) -> None:
        """Check that the names fit into one packet."""
        if 4 + len(self.group) + len(self.name) + 2 > MAX_DATA:
            raise ValueError(f"{self.group}.{self.name}; must have at most {MAX_DATA - 6} letters")


class Toc:
    """Table of contents."""

    def __init__(self, entries: Sequence[TocEntry], extra: bytes = b"") -> None:
        """Take the entries, sorted by group; `extra` is appended to the answer to INFO."""
        self._entries = tuple(entries)
        self._extra = extra
        self.crc = _checksum(self._entries)

    def answer(self, data: bytes) -> bytes | None:
        """Return the answer to a request, None if none is due; raise MalformedError if it is short."""
        if data[:1] == bytes([INFO]):
            return bytes([INFO]) + _COUNT_CRC.pack(len(self._entries), self.crc) + self._extra
        if data[:1] == bytes([ITEM]):
            return bytes([ITEM]) + self._item(int(read_fields(_NUMBER, data, 1)[0]))
        return None

    def _item(self, number: int) -> bytes:
        if number >= len(self._entries):
            return b""
        one = self._entries[number]
        names = f"{one.group}\0{one.name}\0".encode("latin-1")
        return _NUMBER.pack(number) + bytes([one.kind]) + names


def _checksum(entries: tuple[TocEntry, ...]) -> int:
    crc = 0
    for group, members in groupby(entries, key=lambda one: one.group):
        crc = _chained(crc, _GROUP | _START, group)
        for one in members:
            crc = _chained(crc, one.kind, one.name)
        crc = _chained(crc, _GROUP, f"stop_{group}")
    return crc


def _chained(crc: int, kind: int, name: str) -> int:
    return crc32(_CRC.pack(crc) + bytes([kind]) + name.encode("latin-1"))
