"""Say how a node is wired: how many readers each topic it publishes has matched.

Who starts a flight compares the counts with the graph: a reliable writer that has matched a reader loses
nothing to it, so the first tick may go out once every writer has matched every reader.
"""

from rclpy.node import Node
from std_srvs.srv import Trigger

SERVICE = "ready"


def offer_ready(node: Node) -> None:
    """Offer the service `~/ready`: the message lists `topic=matched readers`, separated by blanks."""

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        response.message = " ".join(f"{topic}={count}" for topic, count in matched_readers(node).items())
        return response

    node.create_service(Trigger, f"~/{SERVICE}", answer)


def matched_readers(node: Node) -> dict[str, int]:
    """Return, for each topic the node publishes, how many readers its writer has matched."""
    return {writer.topic_name: writer.get_subscription_count() for writer in node.publishers}
