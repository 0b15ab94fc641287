"""Blocking call of a Trigger service."""

import signal
from collections.abc import Callable
from math import inf
from time import monotonic

import rclpy
from rclpy.client import Client
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from q2q_control.flight_procedure.steps import Call
from q2q_model.node.reply import Reply
from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.node.run import start_ros

SERVED_S = 10.0
"""Longest wait for the service [s]."""
ANSWERED_S = {Call.EMERGENCY.value: 5.0}
"""Longest wait for an answer [s]; one without bound is given when the request is done, e.g. a flight over."""
UNKNOWN = "whether it was done is unknown: look at the vehicles"
WAKE_S = 0.1
"""Period of checking for the end of a wait [s]."""


def ask(service: str, confirm: Callable[[], bool]) -> Reply:
    """Return the answer of a service, or a refusal if it does not exist.

    `confirm` is called once the service is found, and returns whether to call it.

    Raises:
        KeyboardInterrupt: on SIGINT or SIGTERM.
    """
    start_ros([])
    signal.signal(signal.SIGTERM, signal.default_int_handler)
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
    return await_answer(client, executor, ANSWERED_S.get(service.rpartition("/")[2], inf))


def await_answer(client: Client, executor: Executor, longest: float) -> Reply:
    """Return the answer; a refusal after `longest` [s], or once the node has left (20 s after a crash)."""
    answer = client.call_async(Trigger.Request())
    deadline = monotonic() + longest
    while not answer.done():
        if monotonic() > deadline:
            return Reply(granted=False, reason=f"no answer within {longest:g} s; {UNKNOWN}")
        left = not client.service_is_ready()
        executor.spin_until_future_complete(answer, WAKE_S)
        if left and not answer.done():
            return Reply(granted=False, reason=f"the node left without an answer; {UNKNOWN}")
    response = answer.result()
    return Reply(granted=response.success, reason=response.message)
