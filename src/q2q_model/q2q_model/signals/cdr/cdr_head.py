"""frame_id and names of a CDR message (cdr_format), which follow its stamp: written, and read and checked."""

import struct
from functools import lru_cache

from q2q_model.signals.cdr.cdr_format import COUNT, NAMES_AT, WORLD, BadMessageError, aligned
from q2q_model.signals.values import Names

MOST_VEHICLES = 10_000
"""Largest accepted number of names; a larger one means a corrupt message."""


def head_bytes(frame_id: str, names: Names) -> bytes:
    """Return the bytes of frame_id and names, which follow the stamp."""
    made = bytearray(8)  # placeholder for the stamp, which alignment counts
    _add_text(made, frame_id)
    made += bytes(-len(made) % 4) + COUNT.pack(len(names))
    for name in names:
        _add_text(made, name)
    return bytes(made[8:])


def _add_text(made: bytearray, text: str) -> None:
    closed = text.encode() + b"\0"
    made += bytes(-len(made) % 4) + COUNT.pack(len(closed)) + closed


def read_names(data: bytes | bytearray, frame: str) -> tuple[Names, int]:
    """Return the names and the offset of the arrays; the message's frame is `frame`, or not given."""
    (length,) = struct.unpack_from("<I", data, NAMES_AT)
    count_at = aligned(NAMES_AT + 4 + length, 4)
    (count,) = struct.unpack_from("<I", data, count_at)
    if count > MOST_VEHICLES:
        raise BadMessageError(f"{count} names; must be at most {MOST_VEHICLES}")
    at = count_at + 4
    for _ in range(count):
        at = aligned(at, 4)
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
        raise BadMessageError(f"frame_id {frame_id!r}; must be {frame!r}{', z up' if frame == WORLD else ''}")
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
