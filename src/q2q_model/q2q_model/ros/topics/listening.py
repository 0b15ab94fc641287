"""Raw subscription callback that decodes signals and counts invalid messages."""

from collections.abc import Callable
from typing import TypeVar

from q2q_model.node.health import Health
from q2q_model.signals.cdr import SignalReader, header_stamp_ns
from q2q_model.signals.layout import Signal

S = TypeVar("S", bound=Signal)
Take = Callable[[int, S], None]
"""Callback that takes stamp [ns] and signal; raises ValueError for an invalid signal."""


def listener(topic: str, signal: type[S], take: Take[S], health: Health) -> Callable[[bytes], None]:
    """Return a raw subscription callback that passes each decoded message to `take`."""
    reader = SignalReader(signal)

    def receive(data: bytes) -> None:
        try:
            take(header_stamp_ns(data), reader.read(data))
        except ValueError as refusal:
            health.refuse(f"{topic}: {refusal}")

    return receive
