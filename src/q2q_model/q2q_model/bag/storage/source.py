"""A bag of any kind as a list of channels and a stream of bytes."""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Channel:
    """One topic of a bag."""

    topic: str
    type_name: str
    definition: str
    """Text of the message definition; empty if the bag has none."""
    count: int
    latched: bool = False
    """Whether all its publishers offered late subscribers the last message."""


@dataclass(frozen=True, slots=True)
class RawMessage:
    """One message of a bag as bytes."""

    topic: str
    stamp_ns: int
    """Bag time: time of recording [ns]."""
    data: bytes
    type_name: str
    place: tuple[int, ...] = ()
    """Rising in the order of recording; empty if only the bag time is known."""


@dataclass(frozen=True, slots=True)
class Source:
    """Contents of an open bag."""

    path: Path
    channels: tuple[Channel, ...]
    read: Callable[[Collection[str]], Iterator[RawMessage]]
    """Function that yields the messages of topics in order of bag time."""
    repairs: tuple[str, ...]
    ros1: bool = False
    """Whether messages are in ROS 1 serialisation, not CDR."""
    is_cut: bool = False
    """Whether messages may be missing: its writer was killed, or the file was damaged."""
