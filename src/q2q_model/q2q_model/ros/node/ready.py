"""Readiness services of a node: its subscriptions, and the matched subscribers of each publisher.

The start of a flight compares these over all nodes. A reliable publisher loses no message to a matched
subscriber, so the first tick may be sent once every publisher has matched every subscriber. A node that
needs a latched topic also reports it as missing until the value has arrived.
"""

from collections.abc import Callable
from weakref import WeakKeyDictionary

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from std_srvs.srv import Trigger

from q2q_model.node.connections import Connections

SERVICE = "ready"
DRAINED = "drained"
DRAIN = Duration(seconds=0.1)
"""Longest wait for acknowledgement in one request, shorter than the caller's timeout."""

_OUT: WeakKeyDictionary[Node, set[str]] = WeakKeyDictionary()
_LACKS: WeakKeyDictionary[Node, set[str]] = WeakKeyDictionary()


def note_latched(node: Node, writer: Publisher) -> None:
    """Record that a latched topic of a node has a value."""
    _OUT.setdefault(node, set()).add(writer.topic_name)


def expect_latched(node: Node, reader: Subscription) -> Callable[[], None]:
    """Report a latched topic as missing until the returned function is called."""
    topics = _LACKS.setdefault(node, set())
    topics.add(reader.topic_name)
    return lambda: topics.discard(reader.topic_name)


def offer_ready(node: Node) -> None:
    """Offer the service `~/ready`, whose response message is the node's Connections."""

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        response.message = connections_of(node).as_text()
        return response

    node.create_service(Trigger, f"~/{SERVICE}", answer)


def offer_drained(node: Node) -> None:
    """Offer the service `~/drained`: success once every subscriber has acknowledged every message.

    It is called at the end of a flight, so that a slow recorder loses nothing.
    """

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = all(writer.wait_for_all_acked(DRAIN) for writer in node.publishers)
        return response

    node.create_service(Trigger, f"~/{DRAINED}", answer)


def connections_of(node: Node) -> Connections:
    """Return a node's subscriptions and the matched subscribers of each of its publishers."""
    return Connections(
        reads=tuple(one.topic_name for one in node.subscriptions),
        matched={one.topic_name: one.get_subscription_count() for one in node.publishers},
        out=tuple(sorted(_OUT.get(node, ()))),
        lacks=tuple(sorted(_LACKS.get(node, ()))),
    )
