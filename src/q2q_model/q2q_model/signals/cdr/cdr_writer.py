"""Serialization of signals as CDR messages (cdr_format)."""

import struct
from dataclasses import dataclass
from functools import lru_cache

from q2q_model.signals.cdr.cdr_format import (
    ENCAPSULATION,
    NAMES_AT,
    STAMP,
    START,
    BadMessageError,
    dtype_of,
    frame_id_of,
)
from q2q_model.signals.cdr.cdr_head import head_bytes
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.stamps import stamp_parts
from q2q_model.signals.values import Names


def encode(signal: Signal, stamp_ns: int) -> bytes:
    """Return the serialized message of a signal, stamped `stamp_ns` [ns].

    Raises BadMessageError if an array's length does not match the number of names.
    """
    kind: type = type(signal)
    form = _form(kind, signal.names)
    parts = [ENCAPSULATION, STAMP.pack(*stamp_parts(stamp_ns)), form.head]
    for attribute, lead in form.leads:
        parts += (lead, getattr(signal, attribute).tobytes())
    data = b"".join(parts)
    if len(data) != form.size:
        needs = f"{len(signal.names)} names need {form.size}"
        raise BadMessageError(f"{type(signal).__name__} makes {len(data)} bytes; {needs}")
    return data


def encode_stamp(stamp_ns: int) -> bytes:
    """Return a serialized message that consists of a stamp only, such as rosgraph_msgs/Clock."""
    return ENCAPSULATION + STAMP.pack(*stamp_parts(stamp_ns))


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
    head = head_bytes(frame_id_of(kind), names)
    at, leads = NAMES_AT + len(head), []
    for column in LAYOUTS[kind].columns:
        count, itemsize = len(names) * column.width, dtype_of(column)().itemsize
        leads.append((column.attribute, _array_lead((at - START) % 8, count, itemsize)))
        at += len(leads[-1][1]) + count * itemsize
    return _Form(head, tuple(leads), at)


def _array_lead(phase: int, count: int, itemsize: int) -> bytes:
    """Return padding, count and padding before an array's numbers, at an offset of this phase modulo 8."""
    made = bytes(-phase % 4) + struct.pack("<I", count)
    return made + bytes(-(phase + len(made)) % itemsize if count else 0)
