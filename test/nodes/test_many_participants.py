"""Nodes of one machine find each other however many run before them."""

import subprocess
import sys

import pytest

pytest.importorskip("rclpy", reason="ROS is not installed")

from q2q_sim.processes.domain import own_domain

PARTICIPANTS = 40
"""More than the 32 ports that rmw_fastrtps tries by default."""
TIMEOUT_S = 60.0
MATCH = f"""
from time import monotonic
import rclpy
from rclpy.context import Context
from rclpy.duration import Duration
from std_msgs.msg import Empty

def node(k):
    context = Context()
    rclpy.init(context=context)
    return rclpy.create_node(f"node_{{k}}", context=context)

nodes = [node(k) for k in range({PARTICIPANTS})]
writer = nodes[-2].create_publisher(Empty, "topic", 1)
reader = nodes[-1].create_subscription(Empty, "topic", print, 1)
begun = monotonic()
while not writer.get_subscription_count() and monotonic() < begun + {TIMEOUT_S}:
    nodes[-1].get_clock().sleep_for(Duration(seconds=0.05), context=nodes[-1].context)
print(writer.get_subscription_count())
for one in nodes:
    rclpy.shutdown(context=one.context)
"""
"""Start so many participants; print how many readers the last but one has, with the last as a reader."""


def test_the_last_two_of_forty_participants_find_each_other() -> None:
    with own_domain():
        found = subprocess.run([sys.executable, "-c", MATCH], capture_output=True, text=True, check=True)
    assert found.stdout == "1\n"
