"""Watch a flight from outside: wait until its nodes are wired, start it, follow it, read its summary."""

import json
from collections.abc import Callable, Iterable
from time import monotonic
from typing import Self

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.client import Client
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from q2q_model.ros.qos import LATCHED
from q2q_model.ros.ready import SERVICE
from q2q_model.ros.run import make_executor

POLL_S = 0.05
"""How often the graph is asked [s]."""


class FlightDirector:
    """Hold the watcher's node and what it has heard. Use as a context manager."""

    def __init__(self, check: Callable[[], None]) -> None:
        """Take a check that is called while waiting; it raises when a process has died."""
        rclpy.init()
        self._node = Node("flight_director")
        self._executor = make_executor()
        self._executor.add_node(self._node)
        self._check = check
        self._summary: dict[str, float | None] | None = None
        self._ticks = 0
        self._played = False
        self._node.create_subscription(String, "flight_summary", self._on_summary, LATCHED)
        self._node.create_subscription(String, "playback_over", self._on_playback_over, LATCHED)
        self._node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)

    def __enter__(self) -> Self:
        """Return the director."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the graph."""
        rclpy.try_shutdown()

    @property
    def ticks(self) -> int:
        """Return the ticks the simulator has flown, as it last said."""
        return self._ticks

    def wait_wired(self, nodes: Iterable[str], timeout_s: float) -> None:
        """Return once every writer of the named nodes has matched every reader in the graph.

        Raises:
            TimeoutError: naming what is not wired after timeout_s [s].
        """
        clients = {name: self._node.create_client(Trigger, f"{name}/{SERVICE}") for name in nodes}
        deadline = monotonic() + timeout_s
        waiting = dict.fromkeys(clients, "has not answered")
        while waiting:
            if monotonic() > deadline:
                said = "; ".join(f"{name} {why}" for name, why in waiting.items())
                raise TimeoutError(f"nodes not wired after {timeout_s:g} s: {said}")
            waiting = {name: why for name in waiting if (why := self._unwired(clients[name]))}
            self._spin(POLL_S if waiting else 0.0)

    def start(self, source: str = "simulator") -> None:
        """Let the simulator fly, or the bag play: whichever node makes the ticks."""
        client = self._node.create_client(Trigger, f"{source}/start")
        if not client.wait_for_service(timeout_sec=5.0):
            raise TimeoutError(f"the service {source}/start does not answer")
        self._call(client)

    def wait_summary(self, progress: Callable[[int], None]) -> dict[str, float | None]:
        """Return the flight's timing once it is over; call `progress` with the ticks flown meanwhile."""
        while self._summary is None:
            self._spin(POLL_S)
            progress(self._ticks)
        return self._summary

    def wait_playback(self) -> None:
        """Return once the bag has been played to its end."""
        while not self._played:
            self._spin(POLL_S)

    def _unwired(self, client: Client) -> str:
        if not client.service_is_ready():
            return "has not answered"
        answer = self._call(client)
        if answer is None:
            return "has not answered"
        counts = (pair.rpartition("=") for pair in answer.message.split())
        short = [topic for topic, _, n in counts if int(n) < self._node.count_subscribers(topic)]
        return f"waits for readers of {', '.join(short)}" if short else ""

    def _call(self, client: Client) -> Trigger.Response | None:
        future = client.call_async(Trigger.Request())
        deadline = monotonic() + 1.0
        while not future.done() and monotonic() < deadline:
            self._spin(0.01)
        response: Trigger.Response | None = future.result() if future.done() else None
        return response

    def _spin(self, seconds: float) -> None:
        self._check()
        if not rclpy.ok():
            raise KeyboardInterrupt
        until = monotonic() + seconds
        self._executor.spin_once(timeout_sec=seconds)
        while (rest := until - monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=rest)

    def _on_summary(self, message: String) -> None:
        self._summary = json.loads(message.data)

    def _on_playback_over(self, _: String) -> None:
        self._played = True

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.endswith("/simulator"):
                self._ticks = int(next((pair.value for pair in status.values if pair.key == "ticks"), "0"))
