"""Signals of CDR messages (cdr_format), whose arrays are views of the bytes."""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from q2q_model.signals.cdr.cdr_format import (
    COUNT,
    ENCAPSULATION,
    NAMES_AT,
    BadMessageError,
    aligned,
    dtype_of,
    frame_id_of,
    header_stamp_ns,
)
from q2q_model.signals.cdr.cdr_head import read_names
from q2q_model.signals.layout import LAYOUTS, Column, Signal
from q2q_model.signals.stamps import time_from_stamp
from q2q_model.signals.values import Names

S = TypeVar("S", bound=Signal)


def decode(data: bytes, signal: type[S]) -> S:
    """Return the signal in a serialized message; its arrays are read-only views of the bytes.

    Raises:
        BadMessageError: unsupported encoding, truncated data, duplicate names, or wrong array lengths.
    """
    return SignalReader(signal).read(data)


@dataclass(frozen=True, slots=True)
class _Block:
    """Offset and length of one array in a message."""

    field: str
    """Field of the message."""
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
            raise BadMessageError(f"encoding {data[:2].hex()}; must be plain CDR, little endian (0001)")
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
        count = COUNT.unpack_from(data, block.lead_at)[0] if block.lead_at + 4 <= len(data) else block.count
        if count != block.count:
            needs = f"{len(known.names)} names need {block.count}"
            raise BadMessageError(f"{block.field} has {count} numbers; {needs}")
        if block.end > len(data):
            raise BadMessageError(f"message of {len(data)} bytes is truncated in {block.field}")


def _map_of(signal: type, data: bytes | bytearray) -> _Map:
    try:
        names, at = read_names(data, frame_id_of(signal))
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
    ends = [0, *(block.lead_at + COUNT.size for block in blocks)]
    gaps = (block.lead_at - end for block, end in zip(blocks, ends, strict=False))
    return struct.Struct("<" + "".join(f"{gap}xI" for gap in gaps))


def _block(column: Column, at: int, vehicles: int) -> _Block:
    dtype = dtype_of(column)
    itemsize, count = np.dtype(dtype).itemsize, vehicles * column.width
    lead_at = aligned(at, 4)
    begin = aligned(lead_at + 4, itemsize) if count else NAMES_AT
    shape = (vehicles,) if column.width == 1 else (vehicles, column.width)
    end = begin + count * itemsize
    return _Block(column.field, lead_at, begin, end, count, dtype, shape)
