"""Say how a node is wired: what it reads, and how many readers each topic it publishes has matched.

Who starts a flight adds up who reads what and compares: a reliable writer that has matched a reader loses
nothing to it, so the first tick may go out once every writer has matched every reader. A node that needs what
another has latched says so until it has come: matched is not yet delivered.
"""

from collections.abc import Callable
from weakref import WeakKeyDictionary

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from std_srvs.srv import Trigger

from q2q_model.node.wiring import Wiring
from q2q_model.ros.topics.deadlines import asks

SERVICE = "ready"
DRAINED = "drained"
DRAIN = Duration(seconds=0.1)
"""How long one question waits for acknowledgement: shorter than a caller's patience."""

_OUT: WeakKeyDictionary[Node, set[str]] = WeakKeyDictionary()
_LACKS: WeakKeyDictionary[Node, set[str]] = WeakKeyDictionary()


def latched_is_out(node: Node, writer: Publisher) -> None:
    """Note that a latched topic of a node has a value, for readers to come."""
    _OUT.setdefault(node, set()).add(writer.topic_name)


def expect_latched(node: Node, reader: Subscription) -> Callable[[], None]:
    """Let a node not be ready before a latched topic has come to it; call what is returned when it has."""
    topics = _LACKS.setdefault(node, set())
    topics.add(reader.topic_name)
    return lambda: topics.discard(reader.topic_name)


def offer_ready(node: Node) -> None:
    """Offer the service `~/ready`, whose message is the node's Wiring."""

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        response.message = wiring_of(node).as_text()
        return response

    node.create_service(Trigger, f"~/{SERVICE}", answer)


def offer_drained(node: Node) -> None:
    """Offer the service `~/drained`: success once every reader has acknowledged all that was published.

    Who ends a flight asks for it, so that a recorder behind its time loses nothing.
    """

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = all(writer.wait_for_all_acked(DRAIN) for writer in node.publishers)
        return response

    node.create_service(Trigger, f"~/{DRAINED}", answer)


def wiring_of(node: Node) -> Wiring:
    """Return what a node reads, and how many readers each of its writers has matched."""
    readers, writers = list(node.subscriptions), list(node.publishers)
    return Wiring(
        reads=tuple(one.topic_name for one in readers if not asks(one.qos_profile)),
        matched={one.topic_name: one.get_subscription_count() for one in writers},
        watches=tuple(one.topic_name for one in readers if asks(one.qos_profile)),
        promises=tuple(one.topic_name for one in writers if asks(one.qos_profile)),
        out=tuple(sorted(_OUT.get(node, ()))),
        lacks=tuple(sorted(_LACKS.get(node, ()))),
    )
