"""Call the flight procedure from a terminal: take_off, fly, hold, land, emergency.

Prints the answer, and ends with 0 where the call was granted, 1 where it was refused or nobody answers. The calls are
plain std_srvs/Trigger services; `ros2 service call` makes the same where the ROS 2 command line is installed.
"""

import sys
from collections.abc import Sequence
from time import monotonic

import rclpy
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from q2q_control.flight_procedure.steps import Call
from q2q_model.ros.run import make_executor
from q2q_model.tools.command_line import CommandLine

SERVED_S = 10.0
"""Longest wait for the node [s]."""
WAKE_S = 0.1
"""How often the end of a wait is looked for [s]."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Make one call; return the exit status."""
    example = "  ros2 run q2q_control call take_off\n  ros2 run q2q_control call emergency --node crazyswarm"
    made = CommandLine("call", __doc__, example)
    made.add_argument("call", choices=[one.value for one in Call], help="what to ask for")
    made.add_argument("--node", default="radio", help="who flies the vehicles: radio or crazyswarm")
    asked = made.parse_args(arguments)
    rclpy.init(args=[])
    try:
        return _call(f"{asked.node}/{asked.call}")
    except KeyboardInterrupt:
        print("call: interrupted; what was asked for goes on", file=sys.stderr)
        return 130
    finally:
        rclpy.try_shutdown()


def _call(service: str) -> int:
    node, executor = Node("procedure_call"), make_executor()
    executor.add_node(node)
    client = node.create_client(Trigger, service)
    deadline = monotonic() + SERVED_S
    while not client.service_is_ready():
        if monotonic() > deadline:
            print(f"call: nobody serves {service}: is the node running, on this ROS_DOMAIN_ID?", file=sys.stderr)
            return 1
        never: Future[None] = Future()
        executor.spin_until_future_complete(never, WAKE_S)
    answer = client.call_async(Trigger.Request())
    while not answer.done():
        executor.spin_until_future_complete(answer, WAKE_S)
    response = answer.result()
    print(f"{service}: {response.message}", file=sys.stdout if response.success else sys.stderr)
    return 0 if response.success else 1


if __name__ == "__main__":
    sys.exit(main())
