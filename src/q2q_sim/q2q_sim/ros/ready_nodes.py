"""Nodes that a node waits for before it starts by itself: ready, connected with it and with each other."""

from collections.abc import Sequence
from time import monotonic

from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from q2q_model.node.connections import Connections, connections_from_text, missing_connections
from q2q_model.ros.node.ready import SERVICE, connections_of

AGAIN_S = 2.0
"""Time after which a question without an answer is asked again [s]: who was asked may have been restarted."""


class ReadyNodes:
    """Last answers of the nodes' services `~/ready`; asked again at every look."""

    def __init__(self, node: Node, names: Sequence[str]) -> None:
        """Wait for the nodes `names` of the namespace of `node`."""
        self._node = node
        self._clients = {name: node.create_client(Trigger, f"{name}/{SERVICE}") for name in names}
        self._calls: dict[str, tuple[Future, float]] = {}
        self._answers: dict[str, Connections] = {}

    def missing(self) -> list[str]:
        """Return descriptions of the missing connections; empty once the flight may start.

        Raises:
            ValueError: a node's answer is not that of a q2q node.
        """
        now = monotonic()
        for name, (call, asked) in [*self._calls.items()]:
            if call.done():
                del self._calls[name]
                self._answers[name] = connections_from_text(call.result().message, name)
            elif now - asked > AGAIN_S:
                del self._calls[name]
                self._clients[name].remove_pending_request(call)
        for name, client in self._clients.items():
            if name not in self._calls and client.service_is_ready():
                self._calls[name] = client.call_async(Trigger.Request()), now
        own = {self._node.get_name(): connections_of(self._node)}
        return missing_connections((*own, *self._clients), self._answers | own)
