"""Watch the wall clock of a live controller: when ticks stay away, send the fallback command."""

from time import monotonic

from rclpy.node import Node

from q2q_control.fallback import FallbackParams, fallback_command
from q2q_model.ros.tick import TickWiring
from q2q_model.signals import SwarmCommand

PERIOD_S = 0.01
"""How often to look [s]: the tick of the house."""


class CommandWatch:
    """Remember the last command and when it was sent."""

    def __init__(
        self, node: Node, wiring: TickWiring[SwarmCommand], params: FallbackParams, hover_thrust: float
    ) -> None:
        self._wiring = wiring
        self._params = params
        self._hover_thrust = hover_thrust
        self._last: SwarmCommand | None = None
        self._last_ns = 0
        self._sent_at = monotonic()
        wiring.then(self._remember)
        node.create_timer(PERIOD_S, self._look)

    def _remember(self, stamp_ns: int, command: SwarmCommand) -> None:
        self._last, self._last_ns, self._sent_at = command, stamp_ns, monotonic()

    def _look(self) -> None:
        if self._last is None:
            return
        age = monotonic() - self._sent_at
        command = fallback_command(self._last, age, self._params, self._hover_thrust)
        if command is not None:
            self._wiring.health.fallbacks += 1
            self._wiring.publish(self._last_ns + round(age * 1e9), command)
