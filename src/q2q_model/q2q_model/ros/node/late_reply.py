"""Serve a Trigger whose answer may come later: once what was asked for has happened.

rclpy answers a request with what its callback returns, and its events executor runs no coroutines. A response
whose request is still under way is therefore held back where the executor hands it over, and sent when known;
meanwhile the node spins on and can take other calls.
"""

from collections.abc import Callable

from rclpy.node import Node
from std_srvs.srv import Trigger

from q2q_model.node.reply import Reply


class LateReplyService:
    """Trigger service whose requests wait for their answer; at most one request is under way."""

    def __init__(self, node: Node, name: str, ask: Callable[[], Reply | None]) -> None:
        """Call `ask` for each request; where it returns None, the answer comes by `answer`."""
        self._ask = ask
        self._waiting: Trigger.Response | None = None
        self._header: object = None
        service = node.create_service(Trigger, name, self._take)
        self._send = service.send_response
        setattr(service, "send_response", self._hand_over)  # noqa: B010  a method of rclpy's is replaced

    def answer(self, reply: Reply) -> None:
        """Answer the request that waits."""
        if self._waiting is not None:
            response, self._waiting = _filled(self._waiting, reply), None
            self._send(response, self._header)

    def _take(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        reply = self._ask()
        if reply is not None:
            return _filled(response, reply)
        self._waiting = response
        return response

    def _hand_over(self, response: Trigger.Response, header: object) -> None:
        if response is self._waiting:
            self._header = header
        else:
            self._send(response, header)


def _filled(response: Trigger.Response, reply: Reply) -> Trigger.Response:
    response.success, response.message = reply.granted, reply.reason
    return response
