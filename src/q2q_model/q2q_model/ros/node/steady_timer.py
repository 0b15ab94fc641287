"""Call something at a period of the machine's steady time, whatever `use_sim_time` says.

A timer of the node's own clock stands still under use_sim_time until somebody publishes /clock: a simulator
that waits for its own clock would hang, and a node's health would fall silent.
"""

from collections.abc import Callable

from rclpy.clock import Clock, ClockType
from rclpy.node import Node


def steady_timer(node: Node, period_s: float, act: Callable[[], None]) -> None:
    """Call `act` every `period_s` [s] of steady time."""
    node.create_timer(period_s, act, clock=Clock(clock_type=ClockType.STEADY_TIME))
