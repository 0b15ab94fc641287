"""No flight begins while other nodes command the same vehicles, or write what this one reads; landings do."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock
from room_node import RoomNode

from q2q_control.ros import mpc_node
from q2q_control.ros.crazyswarm_bridge import Crazyswarm
from q2q_model.node.health import Health, Level
from q2q_model.ros import interference_node
from q2q_model.ros.node.diagnostics import PERIOD_S
from q2q_model.ros.node.input_warnings import InputWriters
from q2q_model.ros.node.tick import TickWiring
from q2q_model.signals.layout import Signal
from q2q_sim.ros.absent_packages import interface_packages
from q2q_sim.ros.bag_play_node import Player
from q2q_sim.ros.simulator_node import Simulator

BAG = Path(__file__).parents[1] / "bags" / "table2_1"
NAMES = ("cf1", "cf2")
TWO = "command: 2 nodes write it (pid, pid_2); 1 may: stop the others"


@dataclass(frozen=True)
class Writer:
    """Publisher, as ROS describes it."""

    node_name: str


class SharedRoom(RoomNode):
    """Node in a room where other nodes write topics."""

    def __init__(self, **given: object) -> None:
        super().__init__("crazyswarm", {"vehicles": NAMES, **given}, {})
        self.writers: dict[str, tuple[str, ...]] = {}

    def get_publishers_info_by_topic(self, topic: str) -> list[Writer]:
        """Return who writes a topic."""
        return [Writer(name) for name in self.writers.get(topic.removeprefix("/"), ())]

    def get_clock(self) -> Clock:
        """Return the wall clock."""
        return Clock()


@pytest.fixture
def packages(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, module in interface_packages().items():
        monkeypatch.setitem(sys.modules, name, module)


def answer(node: SharedRoom, call: str) -> str:
    """Return the answer to a call of the procedure."""
    node.services[call].call()
    return node.services[call].sent[-1].reason


@pytest.mark.usefixtures("packages")
@pytest.mark.parametrize("call", ["take_off", "fly", "start"])
@pytest.mark.parametrize("topic", ["cf2/cmd_vel_legacy", "cf2/cmd_full_state"])
def test_the_bridge_begins_no_flight_beside_other_setpoints(call: str, topic: str) -> None:
    node = SharedRoom()
    Crazyswarm(node)
    node.writers = {"cf2/cmd_full_state": ("crazyswarm",), topic: ("crazyswarm", "pid")}
    assert answer(node, call) == (
        "other nodes publish setpoints of these vehicles (pid): "
        "stop them, or set legacy_hz:=0 on a controller"
    )
    node.writers = {"cf2/cmd_full_state": ("crazyswarm",)}
    assert "setpoints of these vehicles" not in answer(node, call)


@pytest.mark.usefixtures("packages")
def test_the_bridge_begins_no_flight_by_two_controllers_but_would_land() -> None:
    node = SharedRoom(mode="command")
    Crazyswarm(node)
    node.writers = {"command": ("pid", "pid_2")}
    assert answer(node, "take_off") == TWO
    assert node.lines[-1] == TWO
    assert "the step is offline" in answer(node, "land")


def test_what_is_wrong_with_writers_is_a_doubt_of_health_until_it_is_not() -> None:
    node, health = SharedRoom(), Health()
    inputs = InputWriters(node, ("command", "state"), health)
    assert inputs.look() == ""
    node.writers = {"command": ("pid_2", "pid"), "state": ("mocap_filter",)}
    assert inputs.look() == inputs.look() == TWO
    assert health.doubts == {"command": TWO, "state": ""}
    assert node.lines == [TWO]
    node.writers = {"command": ("pid", "pid")}
    assert inputs.look() == TWO.replace("pid_2", "pid") + "; one that was killed counts until DDS drops it"
    node.writers = {"command": ("pid",)}
    assert inputs.look() == ""
    assert health.doubts == {"command": "", "state": ""}


def room_for(build: Callable[[SharedRoom], object], **given: object) -> tuple[SharedRoom, Callable[[], None]]:
    """Return a room with a node in it, and what reports its health each second."""
    node = SharedRoom(**given)
    build(node)
    [report] = [act for period, act in node.timers if period == PERIOD_S]
    return node, report


@pytest.mark.parametrize(
    ("build", "given", "is_told"),
    [
        (Simulator, {"pace": "live", "autostart": False}, True),
        (Player, {"bag": str(BAG), "autostart": False, "clock": True}, True),
        (Player, {"bag": str(BAG), "autostart": False}, False),
    ],
)
def test_two_clocks_are_told_by_each_node_that_writes_one(
    build: Callable[[SharedRoom], object], given: dict[str, object], *, is_told: bool
) -> None:
    node, report = room_for(build, **given)
    node.writers = {"/clock": ("bag_play", "simulator")}
    report()
    report()
    told = "/clock: 2 nodes write it (bag_play, simulator); 1 may: stop the others"
    assert node.lines.count(told) == int(is_told)
    assert graded(node) == ((Level.WARN, told) if is_told else (Level.STALE, "no tick"))
    node.writers = {"/clock": ("simulator",)}
    report()
    assert graded(node) == (Level.STALE, "no tick")


def graded(node: SharedRoom) -> tuple[Level, str]:
    """Return level and summary of a node's last report."""
    last = node.published["/diagnostics"][-1]
    assert isinstance(last, DiagnosticArray)
    return Level(int.from_bytes(last.status[0].level)), last.status[0].message


@pytest.mark.parametrize(("topic", "build"), [("model", interference_node.build), ("plan", mpc_node.build)])
def test_two_publishers_of_models_or_plans_are_told_each_second(
    topic: str, build: Callable[[RoomNode], TickWiring[Signal]]
) -> None:
    node = SharedRoom(model="none", vehicles=())
    wiring = build(node)
    node.writers = {topic: ("one", "two")}
    [report] = [act for period, act in node.timers if period == PERIOD_S]
    report()
    told = f"{topic}: 2 nodes write it (one, two); 1 may: stop the others"
    assert wiring.health.doubts[topic] == told
    assert node.lines[0] == told
