"""Write and read our messages as the bytes that travel: plain CDR, little endian (DDS-XTypes 1.3, 7.4.1).

Our messages are a header, the names and flat arrays, and nothing else; written directly they cost a tenth of
the way through message objects, which decides how fast lockstep runs. A test holds this file byte for byte
to rclpy and rosbags. Every number is aligned to its size, counted from after the four encapsulation bytes:

    stamp: int32 s, uint32 ns | frame_id: string | names: uint32 n, n strings | per array: uint32 n, n numbers
    string: uint32 length with the closing zero byte, bytes, zero byte
"""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Generic, TypeVar

import numpy as np

from q2q_model.signals.layout import LAYOUTS, Column, Signal
from q2q_model.signals.values import Names, SwarmImu

S = TypeVar("S", bound=Signal)

ENCAPSULATION = b"\x00\x01\x00\x00"
"""Plain CDR, little endian, no options."""
START = len(ENCAPSULATION)
NAMES_AT = START + 8
"""Where frame_id begins: after the stamp."""
NANOSECONDS = 1_000_000_000
WORLD, BODY = "world", "body"
_COUNT = struct.Struct("<I")
_STAMP = struct.Struct("<iI")
MOST_VEHICLES = 10_000
"""More names than this are refused: a swarm of that size is a damaged message."""


class BadMessageError(ValueError):
    """Error for a message whose parts do not fit each other."""


def header_stamp_ns(data: bytes) -> int:
    """Return the stamp [ns] of a message whose first field is std_msgs/Header."""
    if len(data) < NAMES_AT:
        raise BadMessageError(f"message of {len(data)} bytes; one with a header has at least {NAMES_AT}")
    order = "<" if data[1] & 1 else ">"
    sec, nanosec = struct.unpack_from(f"{order}iI", data, START)
    return int(sec) * NANOSECONDS + int(nanosec)


def encode(signal: Signal, stamp_ns: int) -> bytes:
    """Return the bytes of a signal's message under a stamp [ns].

    Raises BadMessageError where its arrays do not fit its names.
    """
    kind: type = type(signal)
    form = _form(kind, signal.names)
    parts = [ENCAPSULATION, _STAMP.pack(*divmod(stamp_ns, NANOSECONDS)), form.head]
    for attribute, lead in form.leads:
        parts += (lead, getattr(signal, attribute).tobytes())
    data = b"".join(parts)
    if len(data) != form.size:
        needs = f"{len(signal.names)} names need {form.size}"
        raise BadMessageError(f"{type(signal).__name__} makes {len(data)} bytes; {needs}")
    return data


def encode_stamp(stamp_ns: int) -> bytes:
    """Return the bytes of a message that is nothing but a stamp, as rosgraph_msgs/Clock."""
    return ENCAPSULATION + _STAMP.pack(*divmod(stamp_ns, NANOSECONDS))


def decode(data: bytes, signal: type[S]) -> S:
    """Return the signal in a message's bytes; its arrays are read-only views of them.

    Raises:
        BadMessageError: another encoding, cut short, repeated names, arrays that do not fit the names.
    """
    return SignalReader(signal).read(data)


@dataclass(frozen=True, slots=True)
class _Block:
    """Offset and length of one array in a message."""

    attribute: str
    field: str
    lead_at: int
    """Where its count stands."""
    begin: int
    """Where its numbers begin."""
    end: int
    """Where they end."""
    count: int
    dtype: type[np.generic]
    shape: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class _Map:
    """Offsets of all fields in messages with these names."""

    head: bytes
    """Bytes of frame_id and names."""
    names: Names
    blocks: tuple[_Block, ...]
    counts: struct.Struct
    """Reads the count of every array, from the first byte of the message on."""
    expected: tuple[int, ...]
    """What they should be."""
    end: int
    """Where the last array ends."""
    views: tuple[tuple[tuple[int, ...], type[np.generic], int], ...]
    """Shape, type and beginning of every array."""


class SignalReader(Generic[S]):
    """Reader of one kind of message; it keeps the last offsets, as names seldom change."""

    def __init__(self, signal: type[S]) -> None:
        self._signal: Callable[..., S] = signal
        self._kind: type = signal
        self._map: _Map | None = None

    def read(self, data: bytes) -> S:
        """Return the signal in a message's bytes; raise as `decode`."""
        if data[:2] != ENCAPSULATION[:2]:
            raise BadMessageError(f"encoding {data[:2].hex()}; allowed is plain CDR, little endian (0001)")
        known = self._map
        if known is None or not data.startswith(known.head, NAMES_AT):
            known = self._map = _map_of(self._kind, data)
        if len(data) < known.end or known.counts.unpack_from(data) != known.expected:
            _refuse(data, known)
        sec, nanosec = _STAMP.unpack_from(data, START)
        arrays = [np.ndarray(shape, dtype, data, begin) for shape, dtype, begin in known.views]
        return self._signal((sec * NANOSECONDS + nanosec) * 1e-9, known.names, *arrays)


def _refuse(data: bytes, known: _Map) -> None:
    """Raise for the first array that does not fit its names, or is cut short."""
    for block in known.blocks:
        count = _COUNT.unpack_from(data, block.lead_at)[0] if block.lead_at + 4 <= len(data) else block.count
        if count != block.count:
            needs = f"{len(known.names)} names need {block.count}"
            raise BadMessageError(f"{block.field} has {count} numbers; {needs}")
        if block.end > len(data):
            raise BadMessageError(f"message of {len(data)} bytes is cut short within {block.field}")


def _map_of(signal: type, data: bytes) -> _Map:
    try:
        names, at = _read_names(data)
    except struct.error as cut:
        raise BadMessageError(f"message of {len(data)} bytes is cut short: {cut}") from cut
    head = data[NAMES_AT:at]
    blocks = []
    for column in LAYOUTS[signal].columns:
        blocks.append(_block(column, at, len(names)))
        at = blocks[-1].end
    counted = blocks if names else []  # without names, some writers pad and some do not
    return _Map(
        head=head,
        names=names,
        blocks=tuple(counted),
        counts=_counter(counted),
        expected=tuple(block.count for block in counted),
        end=max((block.end for block in counted), default=at),
        views=tuple((block.shape, block.dtype, block.begin) for block in blocks),
    )


def _counter(blocks: Sequence[_Block]) -> struct.Struct:
    """Return what reads the counts of these arrays, one after the other."""
    ends = [0, *(block.lead_at + _COUNT.size for block in blocks)]
    gaps = (block.lead_at - end for block, end in zip(blocks, ends, strict=False))
    return struct.Struct("<" + "".join(f"{gap}xI" for gap in gaps))


def _block(column: Column, at: int, vehicles: int) -> _Block:
    dtype = _dtype(column)
    itemsize, count = np.dtype(dtype).itemsize, vehicles * column.width
    lead_at = _aligned(at, 4)
    begin = _aligned(lead_at + 4, itemsize) if count else NAMES_AT
    shape = (vehicles,) if column.width == 1 else (vehicles, column.width)
    end = begin + count * itemsize
    return _Block(column.attribute, column.field, lead_at, begin, end, count, dtype, shape)


def _aligned(at: int, size: int) -> int:
    return at + (START - at) % size


@dataclass(frozen=True, slots=True)
class _Form:
    """Structure shared by messages of a kind with the same names."""

    head: bytes
    """frame_id and names, as they follow the stamp."""
    leads: tuple[tuple[str, bytes], ...]
    """Every attribute, and the bytes that go before its numbers: padding, count, padding."""
    size: int
    """Of the whole message."""


@lru_cache(maxsize=256)
def _form(kind: type, names: Names) -> _Form:
    head = _head(BODY if kind is SwarmImu else WORLD, names)
    at, leads = NAMES_AT + len(head), []
    for column in LAYOUTS[kind].columns:
        count, itemsize = len(names) * column.width, _dtype(column)().itemsize
        leads.append((column.attribute, _array_lead((at - START) % 8, count, itemsize)))
        at += len(leads[-1][1]) + count * itemsize
    return _Form(head, tuple(leads), at)


def _dtype(column: Column) -> type[np.generic]:
    return np.uint8 if column.attribute == "status" else np.float64


def _head(frame_id: str, names: Names) -> bytes:
    """Return frame_id and names, as they follow the stamp."""
    made = bytearray(8)  # stands for the stamp, so that alignment counts from the right place
    _add_text(made, frame_id)
    made += bytes(-len(made) % 4) + _COUNT.pack(len(names))
    for name in names:
        _add_text(made, name)
    return bytes(made[8:])


def _add_text(made: bytearray, text: str) -> None:
    closed = text.encode() + b"\0"
    made += bytes(-len(made) % 4) + _COUNT.pack(len(closed)) + closed


def _array_lead(phase: int, count: int, itemsize: int) -> bytes:
    """Return padding, count and padding before an array's numbers, at a position of this phase modulo 8."""
    made = bytes(-phase % 4) + struct.pack("<I", count)
    return made + bytes(-(phase + len(made)) % itemsize if count else 0)


def _read_names(data: bytes) -> tuple[Names, int]:
    """Return the names and where the arrays begin."""
    (length,) = struct.unpack_from("<I", data, NAMES_AT)
    count_at = _aligned(NAMES_AT + 4 + length, 4)
    (count,) = struct.unpack_from("<I", data, count_at)
    if count > MOST_VEHICLES:
        raise BadMessageError(f"{count} names; allowed are {MOST_VEHICLES}")
    at = count_at + 4
    for _ in range(count):
        at = _aligned(at, 4)
        at += 4 + int(struct.unpack_from("<I", data, at)[0])
    if at > len(data):
        raise BadMessageError(f"message of {len(data)} bytes is cut short within its names")
    return _parsed_head(bytes(data[NAMES_AT:at])), at


@lru_cache(maxsize=64)
def _parsed_head(head: bytes) -> Names:
    """Return the names in the bytes of frame_id and names, checked."""
    texts: list[str] = []
    at = 0
    for field in range(2 + struct.unpack_from("<I", head, _count_at(head))[0]):
        at += -at % 4
        (length,) = struct.unpack_from("<I", head, at)
        at += 4
        if field != 1:
            texts.append(_text(head[at : at + length]))
            at += length
    frame_id, *names = texts
    if frame_id not in ("", WORLD, BODY):
        raise BadMessageError(f"frame_id {frame_id!r}; allowed is {WORLD!r}, z up")
    if len(set(names)) < len(names):
        raise BadMessageError(f"repeated vehicle names in {', '.join(names)}; each may stand once")
    return tuple(names)


def _count_at(head: bytes) -> int:
    end = 4 + int(struct.unpack_from("<I", head, 0)[0])
    return end + -end % 4


def _text(raw: bytes) -> str:
    try:
        return raw.rstrip(b"\0").decode()
    except UnicodeDecodeError as error:
        raise BadMessageError(f"a name is not UTF-8: {raw[:20]!r}") from error
