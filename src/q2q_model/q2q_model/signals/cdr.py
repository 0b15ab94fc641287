"""Serialization of q2q_msgs as plain CDR, little endian (DDS-XTypes 1.3, 7.4.1).

These messages are a header, names and flat arrays only. Direct serialization costs a tenth of conversion
through message objects, which sets the speed of lockstep. A test compares this file byte for byte with rclpy
and rosbags. Every number is aligned to its size, counted from the end of the four encapsulation bytes:

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
from q2q_model.signals.stamps import BadStampError, stamp_from_parts, stamp_parts, time_from_stamp
from q2q_model.signals.values import Names, SwarmImu

S = TypeVar("S", bound=Signal)

ENCAPSULATION = b"\x00\x01\x00\x00"
"""Plain CDR, little endian, no options."""
START = len(ENCAPSULATION)
NAMES_AT = START + 8
"""Offset of frame_id, after the stamp."""
WORLD, BODY = "world", "body"
_COUNT = struct.Struct("<I")
_STAMP = struct.Struct("<iI")
MOST_VEHICLES = 10_000
"""Largest accepted number of names; a larger one means a corrupt message."""


class BadMessageError(ValueError):
    """Error for a malformed or inconsistent message."""


def header_stamp_ns(data: bytes | bytearray) -> int:
    """Return the stamp [ns] of a message whose first field is std_msgs/Header."""
    if len(data) < NAMES_AT:
        raise BadMessageError(f"message has {len(data)} bytes; a header needs at least {NAMES_AT}")
    sec, nanosec = struct.unpack_from("<iI" if data[1] & 1 else ">iI", data, START)
    try:
        return stamp_from_parts(sec, nanosec)
    except BadStampError as bad:
        raise BadMessageError(str(bad)) from bad


def encode(signal: Signal, stamp_ns: int) -> bytes:
    """Return the serialized message of a signal, stamped `stamp_ns` [ns].

    Raises BadMessageError if an array's length does not match the number of names.
    """
    kind: type = type(signal)
    form = _form(kind, signal.names)
    parts = [ENCAPSULATION, _STAMP.pack(*stamp_parts(stamp_ns)), form.head]
    for attribute, lead in form.leads:
        parts += (lead, getattr(signal, attribute).tobytes())
    data = b"".join(parts)
    if len(data) != form.size:
        needs = f"{len(signal.names)} names need {form.size}"
        raise BadMessageError(f"{type(signal).__name__} makes {len(data)} bytes; {needs}")
    return data


def encode_stamp(stamp_ns: int) -> bytes:
    """Return a serialized message that consists of a stamp only, such as rosgraph_msgs/Clock."""
    return ENCAPSULATION + _STAMP.pack(*stamp_parts(stamp_ns))


def decode(data: bytes, signal: type[S]) -> S:
    """Return the signal in a serialized message; its arrays are read-only views of the bytes.

    Raises:
        BadMessageError: unsupported encoding, truncated data, duplicate names, or wrong array lengths.
    """
    return SignalReader(signal).read(data)


@dataclass(frozen=True, slots=True)
class _Block:
    """Offset and length of one array in a message."""

    attribute: str
    field: str
    lead_at: int
    """Offset of its count."""
    begin: int
    """Offset of its first number."""
    end: int
    """Offset past its last number."""
    count: int
    dtype: type[np.generic]
    shape: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class _Map:
    """Offsets of all fields in messages that share these names."""

    head: bytes
    """Bytes of frame_id and names."""
    names: Names
    blocks: tuple[_Block, ...]
    counts: struct.Struct
    """Reader of all array counts, starting at the first byte of the message."""
    expected: tuple[int, ...]
    """Array counts that match the names."""
    end: int
    """Offset past the last array."""
    views: tuple[tuple[tuple[int, ...], type[np.generic], int], ...]
    """Shape, type and offset of each array."""


class SignalReader(Generic[S]):
    """Reader of one message type; reuses the last offsets while the names stay the same."""

    def __init__(self, signal: type[S]) -> None:
        self._signal: Callable[..., S] = signal
        self._kind: type = signal
        self._map: _Map | None = None

    def received(self, data: bytes) -> S:
        """Return the signal in a message that a node got, with arrays of its own.

        They are writable, as those without ROS are: kernels are compiled for these, and would be compiled
        again for read-only ones, in flight.
        """
        return self.read(bytearray(data))

    def read(self, data: bytes | bytearray) -> S:
        """Return the signal in a serialized message; raise as `decode` does."""
        if data[:2] != ENCAPSULATION[:2]:
            raise BadMessageError(f"encoding {data[:2].hex()}; allowed is plain CDR, little endian (0001)")
        known = self._map
        if known is None or not data.startswith(known.head, NAMES_AT):
            known = self._map = _map_of(self._kind, data)
        if len(data) < known.end or known.counts.unpack_from(data) != known.expected:
            _refuse(data, known)
        arrays = [np.ndarray(shape, dtype, data, begin) for shape, dtype, begin in known.views]
        return self._signal(time_from_stamp(header_stamp_ns(data)), known.names, *arrays)


def _refuse(data: bytes | bytearray, known: _Map) -> None:
    """Raise for the first array that is truncated or does not match the names."""
    for block in known.blocks:
        count = _COUNT.unpack_from(data, block.lead_at)[0] if block.lead_at + 4 <= len(data) else block.count
        if count != block.count:
            needs = f"{len(known.names)} names need {block.count}"
            raise BadMessageError(f"{block.field} has {count} numbers; {needs}")
        if block.end > len(data):
            raise BadMessageError(f"message of {len(data)} bytes is truncated in {block.field}")


def _map_of(signal: type, data: bytes | bytearray) -> _Map:
    try:
        names, at = _read_names(data, _frame(signal))
    except struct.error as cut:
        raise BadMessageError(f"message of {len(data)} bytes is truncated: {cut}") from cut
    head = bytes(data[NAMES_AT:at])
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
    """Return a reader of the counts of these arrays, in order."""
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
    """Structure shared by messages of one type with the same names."""

    head: bytes
    """Bytes of frame_id and names, which follow the stamp."""
    leads: tuple[tuple[str, bytes], ...]
    """Each attribute with the bytes before its numbers: padding, count, padding."""
    size: int
    """Length of the whole message [bytes]."""


@lru_cache(maxsize=256)
def _form(kind: type, names: Names) -> _Form:
    head = _head(_frame(kind), names)
    at, leads = NAMES_AT + len(head), []
    for column in LAYOUTS[kind].columns:
        count, itemsize = len(names) * column.width, _dtype(column)().itemsize
        leads.append((column.attribute, _array_lead((at - START) % 8, count, itemsize)))
        at += len(leads[-1][1]) + count * itemsize
    return _Form(head, tuple(leads), at)


def _frame(kind: type) -> str:
    return BODY if kind is SwarmImu else WORLD


def _dtype(column: Column) -> type[np.generic]:
    return np.uint8 if column.attribute == "status" else np.float64


def _head(frame_id: str, names: Names) -> bytes:
    """Return the bytes of frame_id and names, which follow the stamp."""
    made = bytearray(8)  # placeholder for the stamp, which alignment counts
    _add_text(made, frame_id)
    made += bytes(-len(made) % 4) + _COUNT.pack(len(names))
    for name in names:
        _add_text(made, name)
    return bytes(made[8:])


def _add_text(made: bytearray, text: str) -> None:
    closed = text.encode() + b"\0"
    made += bytes(-len(made) % 4) + _COUNT.pack(len(closed)) + closed


def _array_lead(phase: int, count: int, itemsize: int) -> bytes:
    """Return padding, count and padding before an array's numbers, at an offset of this phase modulo 8."""
    made = bytes(-phase % 4) + struct.pack("<I", count)
    return made + bytes(-(phase + len(made)) % itemsize if count else 0)


def _read_names(data: bytes | bytearray, frame: str) -> tuple[Names, int]:
    """Return the names and the offset of the arrays; the message's frame is `frame`, or not given."""
    (length,) = struct.unpack_from("<I", data, NAMES_AT)
    count_at = _aligned(NAMES_AT + 4 + length, 4)
    (count,) = struct.unpack_from("<I", data, count_at)
    if count > MOST_VEHICLES:
        raise BadMessageError(f"{count} names; at most {MOST_VEHICLES} are allowed")
    at = count_at + 4
    for _ in range(count):
        at = _aligned(at, 4)
        at += 4 + int(struct.unpack_from("<I", data, at)[0])
    if at > len(data):
        raise BadMessageError(f"message of {len(data)} bytes is truncated in its names")
    return _parsed_head(bytes(data[NAMES_AT:at]), frame), at


@lru_cache(maxsize=64)
def _parsed_head(head: bytes, frame: str) -> Names:
    """Return the checked names in the bytes of frame_id and names."""
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
    if frame_id not in ("", frame):
        raise BadMessageError(
            f"frame_id {frame_id!r}; allowed is {frame!r}{', z up' if frame == WORLD else ''}"
        )
    if len(set(names)) < len(names):
        raise BadMessageError(f"duplicate vehicle names in {', '.join(names)}; names must be unique")
    return tuple(names)


def _count_at(head: bytes) -> int:
    end = 4 + int(struct.unpack_from("<I", head, 0)[0])
    return end + -end % 4


def _text(raw: bytes) -> str:
    try:
        return raw.rstrip(b"\0").decode()
    except UnicodeDecodeError as error:
        raise BadMessageError(f"a name is not UTF-8: {raw[:20]!r}") from error
