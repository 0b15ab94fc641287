"""Director of a flight through nodes: wait for connections, start, follow, read the summary, drain.

The nodes run in processes of their own, or in this process on one executor.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from time import monotonic
from typing import Self

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.client import Client
from rclpy.executors import Executor
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

from q2q_model.node.connections import (
    Connections,
    conflicting_topics,
    connections_from_text,
    missing_connections,
)
from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.node.ready import DRAINED, SERVICE
from q2q_model.ros.node.run import start_ros
from q2q_model.ros.topics.qos import LATCHED, TICK
from q2q_model.signals.topic_names import PLAYBACK_OVER
from q2q_sim.processes.flight_progress import SUMMARY, FlightProgress, check_one_writer, timing_of_summary
from q2q_sim.simulator.flight_clock import FlightTiming

POLL_S = 0.05
"""Period of graph queries [s]."""
START_S = 60.0
"""Time-out for discovery within processes that are ready [s]; rclpy's own wait polls every 0.25 s."""
DRAIN_S = 60.0
"""Time-out for draining the messages of one node [s]: a starved recorder takes a millisecond a message."""
LINGER_S = 20.0
"""Time after which the middleware has forgotten nodes that were killed [s] (Fast DDS: its lease)."""


class FlightDirector:
    """Node that starts and follows a flight; a context manager."""

    def __init__(self, check: Callable[[], None], executor: Executor | None = None) -> None:
        """Join the graph.

        Args:
            check: called while waiting; raises if a process has died.
            executor: executor of the flight's nodes in this process; None starts ROS with a new one.
        """
        self._started_ros = executor is None
        if self._started_ros:
            start_ros()  # the tool handles signals
        self._node = Node("flight_director")
        self._executor = executor or make_executor()
        self._executor.add_node(self._node)
        self._check = check
        self._progress = FlightProgress(monotonic())
        self._answers: dict[str, Connections] = {}
        """Last answers of the nodes of the flight."""
        self._drains: dict[str, Client] = {}
        """Created before the flight, so that they have discovered their services when it ends."""
        self._node.create_subscription(String, SUMMARY, self._on_summary, LATCHED)
        self._node.create_subscription(String, PLAYBACK_OVER, self._on_playback_over, LATCHED)
        self._node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)

    def __enter__(self) -> Self:
        """Return the director."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the graph; end ROS if the director started it."""
        self._executor.remove_node(self._node)
        self._node.destroy_node()
        if self._started_ros:
            rclpy.try_shutdown()

    def follow_clock(self) -> None:
        """Count the ticks of a flight by /clock; diagnostics report them only once per second."""
        self._node.create_subscription(Clock, "/clock", self._on_clock, TICK)

    @property
    def ticks(self) -> int:
        """Return the number of ticks flown, as last reported."""
        return self._progress.ticks

    def wait_connected(
        self,
        nodes: Iterable[str],
        timeout_s: float,
        meanwhile: Callable[[Sequence[str]], None] = lambda _: None,
    ) -> None:
        """Return once every writer of the named nodes has matched every reader and latched messages arrived.

        Args:
            nodes: names of the nodes.
            timeout_s: longest wait [s].
            meanwhile: called while they are waited for, with descriptions of the missing connections.

        Raises:
            TimeoutError: some are not connected after timeout_s [s], or nodes of other flights write signals,
                too (not looked for in this process, which may still know those of flights before).
            ValueError: a node's answer is not that of a q2q node.
        """
        clients = {name: self._node.create_client(Trigger, f"{name}/{SERVICE}") for name in nodes}
        self._drains = {name: self._drain_client(name) for name in clients}
        deadline = monotonic() + timeout_s
        while waiting := self._waiting(clients):
            if monotonic() > deadline:
                raise TimeoutError(f"nodes not connected after {timeout_s:g} s: {'; '.join(waiting)}")
            meanwhile(waiting)
            self._spin(POLL_S)
        deadline = monotonic() + LINGER_S
        while self._started_ros and (strangers := conflicting_topics(self._answers, self._publishers_of)):
            if monotonic() > deadline:
                raise TimeoutError(f"{strangers}: end them, or give this flight another ROS_DOMAIN_ID")
            self._spin(POLL_S)

    def start(self, source: str = "simulator") -> None:
        """Start the simulator or the bag playback.

        Raises:
            TimeoutError: nobody offers its service.
            ValueError: the node refuses.
        """
        client = self._node.create_client(Trigger, f"{source}/start")
        deadline = monotonic() + START_S
        while not client.service_is_ready():
            if monotonic() > deadline:
                raise TimeoutError(f"the service {source}/start does not answer")
            self._spin(POLL_S)
        answer = self._call(client)
        if answer is not None and not answer.success:
            raise ValueError(f"{source} refuses to start: {answer.message}")
        self._progress.start(monotonic())

    def wait_summary(self, progress: Callable[[int], None]) -> FlightTiming:
        """Return the flight's timing once it is over; `progress` is called with the ticks flown.

        Raises:
            ValueError: what came on `flight_summary` is no timing, or nodes of other flights write it, too
                (not looked for in this process); the error names who writes it.
            TimeoutError: no tick came for STILL_S.
        """
        while (summary := self._progress.summary) is None:
            self._follow()
            progress(self._progress.ticks)
        writers = self._publishers_of(SUMMARY)
        if self._started_ros:
            check_one_writer(writers)
        return timing_of_summary(summary, writers)

    def wait_drained(self, nodes: Iterable[str]) -> None:
        """Return once every reader has all messages of the nodes, or after DRAIN_S.

        Name the recorder last: it answers only after it has taken all earlier messages.
        """
        for name in nodes:
            client = self._drains.pop(name, None) or self._drain_client(name)
            deadline = monotonic() + DRAIN_S
            while monotonic() < deadline:
                answer = self._call(client) if client.service_is_ready() else None
                if answer is not None and answer.success:
                    break
                self._spin(POLL_S)

    def wait_playback(self) -> None:
        """Return at the end of the playback."""
        while not self._progress.is_played:
            self._follow()

    def _follow(self) -> None:
        """Wait briefly; raise TimeoutError if no tick came for too long."""
        self._spin(POLL_S)
        self._progress.check(monotonic())

    def _publishers_of(self, topic: str) -> list[str]:
        return [info.node_name for info in self._node.get_publishers_info_by_topic(topic)]

    def _waiting(self, clients: Mapping[str, Client]) -> list[str]:
        """Return descriptions of the missing connections."""
        answers = {name: self._call(client) for name, client in clients.items() if client.service_is_ready()}
        self._answers = {
            name: connections_from_text(one.message, name) for name, one in answers.items() if one
        }
        return missing_connections(clients, self._answers)

    def _drain_client(self, name: str) -> Client:
        return self._node.create_client(Trigger, f"{name}/{DRAINED}")

    def _call(self, client: Client) -> Trigger.Response | None:
        future = client.call_async(Trigger.Request())
        deadline = monotonic() + 1.0
        while not future.done() and monotonic() < deadline:
            self._check()
            self._executor.spin_once(timeout_sec=POLL_S)
        response: Trigger.Response | None = future.result() if future.done() else None
        return response

    def _spin(self, seconds: float) -> None:
        self._check()
        until = monotonic() + seconds
        self._executor.spin_once(timeout_sec=seconds)
        while (rest := until - monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=rest)

    def _on_clock(self, message: Clock) -> None:
        self._progress.take_clock(message.clock.sec, message.clock.nanosec)

    def _on_summary(self, message: String) -> None:
        self._progress.summary = message.data

    def _on_playback_over(self, _: String) -> None:
        self._progress.is_played = True

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._progress.take_diagnostics(status.name, {pair.key: pair.value for pair in status.values})
