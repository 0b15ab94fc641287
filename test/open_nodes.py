"""Stand-in nodes whose inputs, timers and services can all be given something."""

import sys
from collections.abc import Callable
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock

from q2q_model.ros.node.diagnostics_publisher import PERIOD_S
from q2q_sim.ros.node_configurations import Configuration
from q2q_sim.ros.stand_in import NullEntity, StandInNode


class Alive(NullEntity):
    """Context that runs, timer, and link to a vehicle, which does nothing."""

    def __getattr__(self, _: str) -> Callable[..., bool]:
        """Return a method that does nothing."""
        return lambda *_: True


class Nobody(Alive):
    """Client of a service that nobody serves."""

    def __init__(self, name: str) -> None:
        self.srv_name = name

    def service_is_ready(self) -> bool:
        """Return False: nobody does."""
        return False


class OpenNode(StandInNode):
    """A stand-in node whose inputs can all be given something."""

    sites: set[tuple[str, str]] = set()  # noqa: RUF012  of all nodes
    """File and function of every subscription made."""

    def __init__(self, name: str, given: Configuration) -> None:
        super().__init__(name, {"poses_in": "/poses", "stamps": "header"} | given)
        self.context = Alive()
        self.inputs: list[tuple[str, type, Callable[[object], None]]] = []
        self.timers: list[tuple[float, Callable[[], None]]] = []
        self.services: list[tuple[type, Callable[..., object]]] = []
        self.reports: list[DiagnosticArray] = []
        self.publishers = self.subscriptions = ()

    def create_publisher(self, kind: type, topic: str, qos: object) -> NullEntity:
        """Return a publisher; reports of health are kept."""
        made = super().create_publisher(kind, topic, qos)
        if topic == "/diagnostics":
            made.publish = self.reports.append
        return made

    def create_subscription(
        self, kind: type, topic: str, receive: Callable[..., None], qos: object, **_: object
    ) -> NullEntity:
        """Keep who takes a topic."""
        caller = sys._getframe(1).f_code
        self.sites.add((Path(caller.co_filename).name, caller.co_name))
        self.inputs.append((topic, kind, receive))
        return super().create_subscription(kind, topic, receive, qos)

    def create_timer(self, period: float, act: Callable[[], None], **_: object) -> Alive:
        """Keep a timer."""
        self.timers.append((period, act))
        return Alive()

    def create_service(self, kind: type, name: str, ask: Callable[..., object]) -> NullEntity:
        """Keep a service."""
        self.services.append((kind, ask))
        return super().create_service(kind, name, ask)

    def create_client(self, kind: type, name: str) -> Nobody:
        """Return a client of nobody."""
        super().create_client(kind, name)
        return Nobody(name)

    def get_clock(self) -> Clock:
        """Return a clock."""
        return Clock()

    def act(self) -> None:
        """Let every timer fire, and call every service twice."""
        for _, fire in self.timers:
            fire()
        for kind, ask in 2 * self.services:
            ask(kind.Request(), kind.Response())

    def refused(self) -> int:
        """Return how many messages `/diagnostics` says were refused."""
        for period, fire in self.timers:
            if period == PERIOD_S:
                fire()
        return sum(int(one.value) for one in self.reports[-1].status[0].values if one.key == "refused")
