"""Blocking call of a Trigger service."""

import os
from collections.abc import Callable
from time import monotonic

import rclpy
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from q2q_model.node.loopback import restrict
from q2q_model.node.reply import Reply
from q2q_model.ros.node.run import make_executor

SERVED_S = 10.0
"""Longest wait for the service [s]."""
WAKE_S = 0.1
"""Period of checking for the end of a wait [s]."""


def ask(service: str, confirm: Callable[[], bool]) -> Reply:
    """Return the answer of a service, or a refusal if it does not exist.

    `confirm` is called once the service is found, and returns whether to call it.
    """
    restrict(os.environ)
    rclpy.init(args=[])
    try:
        return _asked(Node("procedure_call"), service, confirm)
    finally:
        rclpy.try_shutdown()


def _asked(node: Node, service: str, confirm: Callable[[], bool]) -> Reply:
    executor = make_executor()
    executor.add_node(node)
    client = node.create_client(Trigger, service)
    deadline = monotonic() + SERVED_S
    while not client.service_is_ready():
        if monotonic() > deadline:
            return Reply(granted=False, reason="no such service: start the node, on this ROS_DOMAIN_ID")
        never: Future[None] = Future()
        executor.spin_until_future_complete(never, WAKE_S)
    if not confirm():
        return Reply(granted=False, reason="not sent")
    answer = client.call_async(Trigger.Request())
    while not answer.done():
        executor.spin_until_future_complete(answer, WAKE_S)
    response = answer.result()
    return Reply(granted=response.success, reason=response.message)
