"""DDS deadline and liveliness on tick topics.

A subscriber that requests a deadline or a liveliness lease does not match a publisher that offers none, such
as other software or a bag player. A second subscriber therefore requests them, for its events only; data
arrive on the plain subscriber from any publisher.

| event | time of the event |
|---|---|
| deadline | `within_s` after the last message, repeated every `within_s` |
| liveliness | `within_s` after a process was killed or stopped; at once if it leaves |

The watching subscriber receives every message a second time, unread: 1 % of a core at 100 Hz.
"""

from collections.abc import Callable

from rclpy.duration import Duration
from rclpy.event_handler import (
    QoSLivelinessChangedInfo,
    QoSRequestedDeadlineMissedInfo,
    SubscriptionEventCallbacks,
)
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy, QoSProfile, ReliabilityPolicy

from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import TICK_WRITER
from q2q_model.signals.layout import Signal


def publisher_qos(seconds: float) -> QoSProfile:
    """Return a tick publisher's QoS that offers a deadline and lease of `seconds`; 0 offers none."""
    if seconds <= 0.0:
        return TICK_WRITER
    return _deadline_qos(seconds, TICK_WRITER.depth, TICK_WRITER.reliability)


def watch(node: Node, topic: str, signal: type[Signal], within_s: float, act: Callable[[], None]) -> None:
    """Call `act` whenever a publisher that offers a deadline has been silent or gone for `within_s` [s]."""

    def late(_: QoSRequestedDeadlineMissedInfo) -> None:
        act()

    def changed(event: QoSLivelinessChangedInfo) -> None:
        if event.alive_count_change < 0:
            act()

    events = SubscriptionEventCallbacks(deadline=late, liveliness=changed, use_default_callbacks=False)
    quality = _deadline_qos(within_s, 1, ReliabilityPolicy.BEST_EFFORT)
    node.create_subscription(MESSAGES[signal], topic, _unread, quality, event_callbacks=events, raw=True)


def has_deadline(quality: QoSProfile) -> bool:
    """Return whether a subscriber requests, or a publisher offers, a deadline."""
    return bool(quality.deadline.nanoseconds > 0)


def _deadline_qos(seconds: float, depth: int, reliability: ReliabilityPolicy) -> QoSProfile:
    within = Duration(seconds=seconds)
    return QoSProfile(
        depth=depth,
        reliability=reliability,
        deadline=within,
        liveliness=LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=within,
    )


def _unread(_: bytes) -> None:
    """Ignore a message; the plain subscriber receives it."""
