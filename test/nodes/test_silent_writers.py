"""What a live controller does between its ticks: answer for a writer that died, and an emergency."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from spun_until import spin_until
from std_srvs.srv import Empty

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.ros import guarded_commands, mpc_node, pid_node
from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.values import CommandStatus, SwarmCommand
from q2q_sim.processes.domain import own_domain

WRITER = """
from rclpy.node import Node
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.node.run import run
from q2q_model.signals.values import Interference, SwarmSetpoint, SwarmState
kinds = {"state": SwarmState, "reference_safe": SwarmSetpoint, "interference": Interference}
def build(node):
    writers = {topic: node.create_publisher(MESSAGES[kind], topic, 10) for topic, kind in kinds.items()}
    tick = [0]
    def write():
        for topic, kind in kinds.items():
            signal = synthetic_signal(kind, tick[0] * 0.01, ("cf1", "cf2"))
            writers[topic].publish(encode(signal, tick[0] * 10_000_000))
        tick[0] += 1
    node.create_timer(0.01, write)
run("writer", build)
"""


class Scene:
    """A live controller, whose wall clock the test sets, and the writer that it receives from."""

    def __init__(self, build: Callable[[Node], TickWiring[SwarmCommand]]) -> None:
        rclpy.init()
        self.now = 0.0
        """What the controller's clock shows [s]; while it stands still, no tick is late."""
        self._tick, self._ticked = 0, 0.0
        live = [Parameter("live", value=True), Parameter("legacy_hz", value=0.0)]
        self.node = Node("pid", parameter_overrides=live)
        self.wiring = build(self.node)
        self.received: list[SwarmCommand] = []
        kind = MESSAGES[SwarmCommand]
        self.node.create_subscription(kind, "command", self._hear, 10, raw=True)
        self._executor = make_executor()
        self._executor.add_node(self.node)
        self.writer = subprocess.Popen([sys.executable, "-c", WRITER])

    def _hear(self, data: bytes) -> None:
        self.received.append(decode(data, SwarmCommand))

    def until(self, reached: Callable[[], bool], what: str) -> None:
        """Let callbacks run until something is so."""
        spin_until(self._executor, reached, what)

    def until_flying(self) -> None:
        """Let callbacks run until 20 ticks came."""
        self.until(lambda: self.wiring.health.ticks >= 20 and bool(self.received), "ticks")

    def until_answered(self, status: CommandStatus, age: float) -> None:
        """Show the clock `age` [s] after the last tick, a late one too, until the command has a status."""

        def answered() -> bool:
            if self.wiring.health.ticks != self._tick:
                self._tick, self._ticked = self.wiring.health.ticks, self.now
            self.now = self._ticked + age
            return self.worst() == status

        self.until(answered, status.name)

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
        made = Scene(request.param)
        monkeypatch.setattr(guarded_commands, "monotonic", lambda: made.now)
        yield made
        made.close()


@pytest.mark.parametrize("scene", [pid_node.build], ids=["pid"], indirect=True)
@pytest.mark.parametrize("blow", [signal.SIGKILL, signal.SIGSTOP])
def test_the_death_of_a_writer_leads_through_the_fallback_phases(scene: Scene, blow: signal.Signals) -> None:
    scene.until_flying()
    os.kill(scene.writer.pid, blow)
    params = FallbackParams()
    phases = {
        CommandStatus.HOLD: params.hold_after_s,
        CommandStatus.LEVEL: params.level_after_s,
        CommandStatus.LAND: params.land_after_s,
    }
    for status, age in phases.items():
        scene.until_answered(status, age)
    stamps = [command.t for command in scene.received]
    assert stamps == sorted(stamps)


@pytest.mark.parametrize("scene", [pid_node.build, mpc_node.build], ids=["pid", "mpc"], indirect=True)
def test_the_emergency_service_cuts_the_motors_of_a_running_controller_for_good(scene: Scene) -> None:
    scene.until_flying()
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
