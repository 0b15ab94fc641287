"""Timer on the machine's steady clock, independent of `use_sim_time`.

Under use_sim_time a timer on the node's clock does not run until /clock is published: a simulator would wait
for its own clock, and health reports would stop.
"""

from collections.abc import Callable

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.timer import Timer


def steady_timer(node: Node, period_s: float, act: Callable[[], None]) -> Timer:
    """Call `act` every `period_s` [s] of steady time, until the timer is cancelled."""
    return node.create_timer(period_s, act, clock=Clock(clock_type=ClockType.STEADY_TIME))
