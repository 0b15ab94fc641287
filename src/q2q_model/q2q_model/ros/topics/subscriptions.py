"""Raw subscriptions that decode signals and refuse invalid messages."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeVar

from rclpy.node import Node

from q2q_model.diagnostics.health import Health
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import TICK
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.cdr.cdr_reader import SignalReader
from q2q_model.signals.layout import Signal

S = TypeVar("S", bound=Signal)
Take = Callable[[int, S], None]
"""Callback that takes stamp [ns] and signal; raises ValueError for an invalid signal."""


def listener(
    topic: str, signal: type[S], take: Take[S], refuse: Callable[[str], None]
) -> Callable[[bytes], None]:
    """Return a raw subscription callback that passes each decoded message to `take`.

    `refuse` is called with topic and reason of an invalid one.
    """
    reader = SignalReader(signal)

    def receive(data: bytes) -> None:
        try:
            take(header_stamp_ns(data), reader.received(data))
        except ValueError as refusal:
            refuse(f"{topic}: {refusal}")

    return receive


def subscribe_signals(
    node: Node, topics: Mapping[str, type[Signal]], take: Callable[[str, int, Signal], None], health: Health
) -> None:
    """Subscribe to signals; `take` is called with topic, stamp [ns] and signal, and may raise ValueError."""
    for topic, signal in topics.items():
        receive = listener(topic, signal, partial(take, topic), health.refuse)
        node.create_subscription(MESSAGES[signal], topic, receive, TICK, raw=True)
