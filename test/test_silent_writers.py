"""What a live controller hears beside its ticks: that a writer died, and that there is an emergency."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from time import monotonic

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Empty

from q2q_control.failsafe.ladder import FallbackParams
from q2q_control.ros import guarded_commands, mpc_node, pid_node
from q2q_model.node.wiring import PROMISE_S
from q2q_model.ros.node.run import make_executor
from q2q_model.ros.node.tick import TickWiring
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.signals.cdr import decode
from q2q_model.signals.values import CommandStatus, SwarmCommand
from q2q_sim.flight.scenario_flight import FlightRequest, node_specs
from q2q_sim.processes.domain import own_domain
from q2q_sim.scenarios import library

PATIENCE_S = 60.0
"""For processes to start and find each other on a busy machine [s]."""
WRITER = """
import sys
from rclpy.node import Node
from q2q_model.signals.cdr import encode
from q2q_model.node.rehearsal import rehearsal
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.deadlines import publisher_qos
from q2q_model.ros.node.run import run
from q2q_model.signals.values import Interference, SwarmSetpoint, SwarmState
kinds = {"state": SwarmState, "reference_safe": SwarmSetpoint, "interference": Interference}
def build(node):
    quality = publisher_qos(float(sys.argv[1]))
    writers = {topic: node.create_publisher(MESSAGES[kind], topic, quality) for topic, kind in kinds.items()}
    tick = [0]
    def write():
        for topic, kind in kinds.items():
            signal = rehearsal(kind, tick[0] * 0.01, ("cf1", "cf2"))
            writers[topic].publish(encode(signal, tick[0] * 10_000_000))
        tick[0] += 1
    node.create_timer(0.01, write)
run("writer", build)
"""


class Untimed(Node):  # type: ignore[misc]  # rclpy has no types
    """A node whose own timers never look: what it sends without a tick, an event made it send."""

    def create_timer(self, *_: object, **__: object) -> None:
        """Let no time pass."""


class Scene:
    """A live controller without timers, whose wall clock the test sets, and the writer that it hears."""

    def __init__(self, promise_s: float, build: Callable[[Node], TickWiring[SwarmCommand]]) -> None:
        rclpy.init()
        self.now = 0.0
        """What the controller's clock shows [s]; while it stands still, no tick is late."""
        live = [Parameter("live", value=True), Parameter("legacy_hz", value=0.0)]
        self.node = Untimed("pid", parameter_overrides=live)
        self.wiring = build(self.node)
        self.received: list[SwarmCommand] = []
        kind = MESSAGES[SwarmCommand]
        self.node.create_subscription(kind, "command", self._hear, 10, raw=True)
        self._executor = make_executor()
        self._executor.add_node(self.node)
        self.writer = subprocess.Popen([sys.executable, "-c", WRITER, str(promise_s)])

    def _hear(self, data: bytes) -> None:
        self.received.append(decode(data, SwarmCommand))

    def until(self, reached: Callable[[], bool], what: str) -> None:
        """Let callbacks run until something is so."""
        deadline = monotonic() + PATIENCE_S
        while not reached():
            assert monotonic() < deadline, f"{what}: not within {PATIENCE_S} s"
            self._executor.spin_once(timeout_sec=0.05)

    def until_watched(self) -> None:
        """Let callbacks run until the readers that watch have matched too, and 20 more ticks came."""
        self.until(lambda: all(reader.get_publisher_count() for reader in self.node.subscriptions), "writers")
        ticks = self.wiring.health.ticks + 20
        self.until(lambda: self.wiring.health.ticks >= ticks and bool(self.received), "ticks")

    def until_silent(self) -> None:
        """Let callbacks run, the clock standing still, until ten silences were told since the last tick."""
        health, tick, told = self.wiring.health, -1, 0

        def silent() -> bool:
            nonlocal tick, told
            silences = int(health.extra.get("silences", 0))
            if health.ticks != tick:
                tick, told = health.ticks, silences
            return silences >= told + 10

        self.until(silent, "silence")

    def worst(self) -> int:
        """Return the status of the last command, 0 before the first."""
        return int(self.received[-1].status.max()) if self.received else 0

    def close(self) -> None:
        """End writer, node and ROS; a node that is left listens in its domain while this process lives."""
        self.writer.kill()
        self.writer.wait()
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown()


@pytest.fixture
def scene(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[Scene]:
    with own_domain():
        made = Scene(*request.param)
        monkeypatch.setattr(guarded_commands, "monotonic", lambda: made.now)
        yield made
        made.close()


@pytest.mark.parametrize("scene", [(PROMISE_S, pid_node.build)], indirect=True)
@pytest.mark.parametrize("blow", [signal.SIGKILL, signal.SIGSTOP])
def test_without_any_timer_the_death_of_a_writer_leads_down_the_ladder(
    scene: Scene, blow: signal.Signals
) -> None:
    scene.until_watched()
    os.kill(scene.writer.pid, blow)
    scene.until_silent()
    params = FallbackParams()
    ladder = {
        CommandStatus.HOLD: params.hold_s,
        CommandStatus.LEVEL: params.level_s,
        CommandStatus.LAND: params.land_s,
    }
    for status, age in ladder.items():
        scene.now = age
        scene.until(lambda status=status: scene.worst() == status, status.name)
    assert int(scene.wiring.health.extra["silences"]) >= 3
    stamps = [command.t for command in scene.received]
    assert stamps == sorted(stamps)


@pytest.mark.parametrize("scene", [(0.0, pid_node.build)], indirect=True)
def test_a_writer_that_promises_nothing_is_heard_all_the_same(scene: Scene) -> None:
    scene.until(lambda: scene.wiring.health.ticks >= 20 and bool(scene.received), "ticks")
    assert scene.worst() <= CommandStatus.SATURATED
    assert "silences" not in scene.wiring.health.extra


@pytest.mark.parametrize(
    "scene", [(0.0, pid_node.build), (0.0, mpc_node.build)], ids=["pid", "mpc"], indirect=True
)
def test_the_emergency_service_cuts_the_motors_of_a_running_controller_for_good(scene: Scene) -> None:
    scene.until(lambda: scene.wiring.health.ticks >= 20 and bool(scene.received), "ticks")
    assert scene.received[-1].thrust.min() > 0.0
    client = scene.node.create_client(Empty, "all/emergency")
    scene.until(client.service_is_ready, "all/emergency")
    answer = client.call_async(Empty.Request())
    scene.until(answer.done, "answer")
    scene.until(lambda: scene.worst() == CommandStatus.CUT, "the cut")
    scene.received.clear()
    scene.until(lambda: len(scene.received) >= 100, "a second of ticks")
    for command in scene.received:
        assert command.thrust.tolist() == [0.0, 0.0]
        assert command.status.tolist() == [CommandStatus.CUT] * 2


def test_nodes_promise_in_a_live_flight_and_never_in_lockstep(tmp_path: Path) -> None:
    scenario = library.load("table6")
    live, lockstep = (
        {
            spec.executable: spec.parameters.get("promise_s", 0.0)
            for spec in node_specs(scenario, FlightRequest("table6", live=live), tmp_path, tmp_path / "bag")
        }
        for live in (True, False)
    )
    road = ("mocap_filter", "interference", "trajectory", "replanner", "pid")
    assert {name: live[name] for name in road} == dict.fromkeys(road, PROMISE_S)
    assert set(lockstep.values()) == {0.0}
