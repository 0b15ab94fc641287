"""Hear signals on a topic: bytes in, stamp and signal out, and what cannot be used is counted as refused."""

from collections.abc import Callable
from typing import TypeVar

from q2q_model.node.health import Health
from q2q_model.signals.cdr import SignalReader, header_stamp_ns
from q2q_model.signals.layout import Signal

S = TypeVar("S", bound=Signal)
Take = Callable[[int, S], None]
"""Takes stamp [ns] and signal; raises ValueError for one it cannot use."""


def listener(topic: str, signal: type[S], take: Take[S], health: Health) -> Callable[[bytes], None]:
    """Return a callback of a raw subscription that gives every message of a topic to `take`."""
    reader = SignalReader(signal)

    def receive(data: bytes) -> None:
        try:
            take(header_stamp_ns(data), reader.read(data))
        except ValueError as refusal:
            health.refuse(f"{topic}: {refusal}")

    return receive
