"""Turn signals into messages and back, checking them at the boundary.

A stamp is kept in nanoseconds beside the signal's float time: nodes join by it exactly and copy it into
whatever they make of the tick.
"""

from array import array
from typing import TypeVar

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from q2q_msgs import msg as q2q_msg
from std_msgs.msg import Header

from q2q_model.layout import LAYOUTS, Signal
from q2q_model.signals import Interference, MocapFrame, SwarmCommand, SwarmImu, SwarmSetpoint, SwarmState

S = TypeVar("S", MocapFrame, SwarmState, SwarmSetpoint, Interference, SwarmCommand, SwarmImu)

MESSAGES = {signal: getattr(q2q_msg, layout.message) for signal, layout in LAYOUTS.items()}
"""The message class of each signal class."""

WORLD = "world"
NANOSECONDS = 1_000_000_000


class BadMessageError(ValueError):
    """Refuse a message whose arrays do not fit each other."""


def stamp_ns_of(message: q2q_msg.MocapFrame) -> int:
    """Return the stamp of a message's header [ns]."""
    stamp = message.header.stamp
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)


def header_at(stamp_ns: int) -> Header:
    """Return a header in the world frame with this stamp."""
    sec, nanosec = divmod(stamp_ns, NANOSECONDS)
    return Header(stamp=Time(sec=sec, nanosec=nanosec), frame_id=WORLD)


def encode(signal: Signal, stamp_ns: int) -> q2q_msg.MocapFrame:
    """Return the message of a signal."""
    message = MESSAGES[type(signal)]()
    message.header = header_at(stamp_ns)
    message.names = list(signal.names)
    for column in LAYOUTS[type(signal)].columns:
        setattr(message, column.field, _flat(getattr(signal, column.attribute)))
    return message


def decode(message: q2q_msg.MocapFrame, signal: type[S]) -> S:
    """Return the signal in a message.

    Raises BadMessageError for array lengths that do not fit the names, repeated names or another frame.
    """
    names = tuple(message.names)
    _check_names(names, message.header.frame_id)
    arrays = {
        column.attribute: _rows(getattr(message, column.field), len(names), column.width, column.field)
        for column in LAYOUTS[signal].columns
    }
    return signal(t=stamp_ns_of(message) * 1e-9, names=names, **arrays)


def _flat(values: NDArray[np.generic]) -> "array[float] | array[int]":
    flat: array[float] | array[int] = array("B") if values.dtype == np.uint8 else array("d")
    flat.frombytes(values.tobytes())
    return flat


def _check_names(names: tuple[str, ...], frame_id: str) -> None:
    if len(set(names)) < len(names):
        raise BadMessageError(f"repeated vehicle names in {', '.join(names)}; each may stand once")
    if frame_id not in ("", WORLD, "body"):
        raise BadMessageError(f"frame_id {frame_id!r}; allowed is {WORLD!r}, z up")


def _rows(flat: "array[float]", count: int, width: int, field: str) -> NDArray[np.float64]:
    if len(flat) != count * width:
        raise BadMessageError(f"{field} has {len(flat)} numbers; {count} names need {count * width}")
    dtype = np.uint8 if isinstance(flat, bytes | np.ndarray) or flat.typecode == "B" else np.float64
    rows = np.frombuffer(flat, dtype=dtype)
    return rows if width == 1 else rows.reshape(count, width)
