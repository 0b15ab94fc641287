"""The node `crazyswarm` does not take itself for another node, in any namespace."""

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node

from q2q_control.radio.link.rpyt_scale import RpytScale
from q2q_control.ros.crazyswarm_commands import CrazyswarmCommands
from q2q_sim.processes.domain import own_domain


@pytest.mark.parametrize("namespace", ["", "room", "hall/room"])
def test_only_other_nodes_conflict_in_any_namespace(namespace: str) -> None:
    with own_domain():
        rclpy.init(args=[])
        try:
            node = Node("crazyswarm", namespace=namespace)
            scale = RpytScale(full_pwm_thrust=0.6)
            commands = CrazyswarmCommands(node, ("cf1",), (scale, "cpp"), full_state=False)
            assert commands.conflicts() == ""
            other = Node("pid", namespace=namespace)
            other.create_publisher(Twist, "cf1/cmd_vel_legacy", 1)
            assert f"({namespace}/pid)".replace("(/", "(") in commands.conflicts()
        finally:
            rclpy.try_shutdown()
