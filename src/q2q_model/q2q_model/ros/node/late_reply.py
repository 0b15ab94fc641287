"""Trigger service with a deferred response.

rclpy sends the response that the callback returns, and its events executor does not run coroutines. The
executor's send_response is therefore replaced: the response of a pending request is withheld and sent once
the request has completed, while the node keeps spinning.
"""

from collections.abc import Callable

from rclpy.node import Node
from std_srvs.srv import Trigger

from q2q_model.node.reply import Reply


class LateReplyService:
    """Trigger service with deferred responses."""

    def __init__(self, node: Node, name: str, ask: Callable[[], Reply | None]) -> None:
        """Call `ask` for each request; if it returns None, `answer` sends the response later."""
        self._ask = ask
        self._withheld: Trigger.Response | None = None
        self._pending: list[tuple[Trigger.Response, object]] = []
        service = node.create_service(Trigger, name, self._take)
        self._send = service.send_response
        setattr(service, "send_response", self._hand_over)  # noqa: B010  a method of rclpy's is replaced

    def answer(self, reply: Reply) -> None:
        """Send the response of all pending requests."""
        pending, self._pending = self._pending, []
        for response, header in pending:
            self._send(_filled(response, reply), header)

    def _take(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        reply = self._ask()
        if reply is not None:
            return _filled(response, reply)
        self._withheld = response
        return response

    def _hand_over(self, response: Trigger.Response, header: object) -> None:
        if response is self._withheld:
            self._withheld = None
            self._pending.append((response, header))
        else:
            self._send(response, header)


def _filled(response: Trigger.Response, reply: Reply) -> Trigger.Response:
    response.success, response.message = reply.granted, reply.reason
    return response
