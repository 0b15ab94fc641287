"""Promise readers a signal at least so often, and be told by DDS when a promise is broken.

A reader that asks for a deadline or a lease hears nothing from a writer that promises none, as other software
or a player of bags. So a topic is watched by a second reader, that asks, and is there for its events only:
who promises is watched, who does not is heard all the same.

| event | told |
|---|---|
| deadline | `within_s` after the last message, and every `within_s` again |
| liveliness | `within_s` after a process was killed or stopped; at once where it leaves |

The watching reader takes every message a second time, without looking at it: 100 Hz are 1 % of a core.
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


def promising(seconds: float) -> QoSProfile:
    """Return a tick writer's quality of service with a deadline and a lease of `seconds`; 0 promises none."""
    if seconds <= 0.0:
        return TICK_WRITER
    return _asking(seconds, TICK_WRITER.depth, TICK_WRITER.reliability)


def watch(node: Node, topic: str, signal: type[Signal], within_s: float, act: Callable[[], None]) -> None:
    """Call `act` whenever a promising writer of a topic has been silent, or gone, for `within_s` [s]."""

    def late(_: QoSRequestedDeadlineMissedInfo) -> None:
        act()

    def changed(event: QoSLivelinessChangedInfo) -> None:
        if event.alive_count_change < 0:
            act()

    events = SubscriptionEventCallbacks(deadline=late, liveliness=changed, use_default_callbacks=False)
    asking = _asking(within_s, 1, ReliabilityPolicy.BEST_EFFORT)
    node.create_subscription(MESSAGES[signal], topic, _unread, asking, event_callbacks=events, raw=True)


def asks(quality: QoSProfile) -> bool:
    """Return whether a reader watches, or a writer promises."""
    return bool(quality.deadline.nanoseconds > 0)


def _asking(seconds: float, depth: int, reliability: ReliabilityPolicy) -> QoSProfile:
    within = Duration(seconds=seconds)
    return QoSProfile(
        depth=depth,
        reliability=reliability,
        deadline=within,
        liveliness=LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=within,
    )


def _unread(_: bytes) -> None:
    """Leave a message to the reader that is there for it."""
