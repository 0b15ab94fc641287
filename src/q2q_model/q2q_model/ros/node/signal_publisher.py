"""Publisher of a signal: to listeners within the process by its bus, on ROS where anyone subscribes."""

from functools import partial
from typing import Generic, TypeVar

from rclpy.node import Node
from rclpy.qos import QoSProfile

from q2q_model.ros.node.bus_node import bus_of
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.subscriber_check import SubscriberCheck
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import Signal

S = TypeVar("S", bound=Signal)


class SignalPublisher(Generic[S]):
    """Publisher of one topic."""

    def __init__(self, node: Node, topic: str, signal: type[S], quality: QoSProfile) -> None:
        self._topic = topic
        self._bus = bus_of(node)
        self._publisher = node.create_publisher(MESSAGES[signal], topic, quality)
        self._check = SubscriberCheck((self._publisher,))

    def post(self, stamp_ns: int, signal: S) -> None:
        """Deliver a signal within the process, then publish it with its stamp [ns]."""
        self._bus.post(self._topic, stamp_ns, signal, partial(self.publish, stamp_ns, signal))

    def publish(self, stamp_ns: int, signal: S) -> None:
        """Publish a signal on ROS; without subscribers it is not even encoded."""
        if self._check.has_subscribers(stamp_ns):
            self._publisher.publish(encode(signal, stamp_ns))
