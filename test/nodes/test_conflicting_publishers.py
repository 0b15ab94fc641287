"""No flight begins while other nodes command the same vehicles, or write what this one reads; landings do."""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from resting_signals import level_command

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from room_node import RoomNode, Writer

from q2q_control.ros import mpc_node, pid_node
from q2q_control.ros.crazyswarm_bridge import Crazyswarm
from q2q_model.diagnostics.health import Health, Level
from q2q_model.geometry.rotations import identity_quat
from q2q_model.ros import interference_node, mocap_filter_node
from q2q_model.ros.node.publisher_conflicts import PublisherConflicts
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import MocapFrame, Names
from q2q_model.trajectory import plan_file
from q2q_planner.ros import replanner_node, trajectory_node
from q2q_sim.loop import flight_blocks
from q2q_sim.ros.absent_packages import interface_packages
from q2q_sim.ros.bag_play_node import Player
from q2q_sim.ros.simulator_node import Simulator
from q2q_sim.scenarios import library

BAG = Path(__file__).parents[2] / "bags" / "table2_1"
NAMES = ("cf1", "cf2")
TWO = "command: 2 nodes write it (pid, pid_2); 1 may: stop the others"


class SharedRoom(RoomNode):
    """Node in a room where other nodes write topics."""

    def __init__(self, **given: object) -> None:
        super().__init__("crazyswarm", {"vehicles": NAMES, **given}, {})
        self.namespaces: tuple[str, ...] = ()

    def get_publishers_info_by_topic(self, topic: str) -> list[Writer]:
        """Return who writes a topic."""
        names = self.writers.get(topic.removeprefix("/"), ())
        places = self.namespaces or ("/",) * len(names)
        return [Writer(name, place) for name, place in zip(names, places, strict=False)]


@pytest.fixture
def packages(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, module in interface_packages().items():
        monkeypatch.setitem(sys.modules, name, module)


@pytest.mark.usefixtures("packages")
@pytest.mark.parametrize("call", ["take_off", "fly", "start"])
@pytest.mark.parametrize("topic", ["cf2/cmd_vel_legacy", "cf2/cmd_full_state"])
def test_the_bridge_begins_no_flight_beside_other_setpoints(call: str, topic: str) -> None:
    node = SharedRoom()
    Crazyswarm(node)
    node.writers = {"cf2/cmd_full_state": ("crazyswarm",), topic: ("crazyswarm", "pid")}
    assert node.answer(call) == (
        "other nodes publish setpoints of these vehicles (pid): "
        "stop them, or set legacy_hz:=0 on a controller"
    )
    node.writers = {"cf2/cmd_full_state": ("crazyswarm",)}
    assert "setpoints of these vehicles" not in node.answer(call)


@pytest.mark.usefixtures("packages")
def test_the_bridge_begins_no_flight_by_two_controllers_but_would_land() -> None:
    node = SharedRoom(mode="command")
    Crazyswarm(node)
    node.writers = {"command": ("pid", "pid_2")}
    assert node.answer("take_off") == TWO
    assert node.lines[-1] == TWO
    assert "the step is offline" in node.answer("land")


def test_what_is_wrong_with_writers_is_a_doubt_of_health_until_it_is_not() -> None:
    node, health = SharedRoom(), Health()
    inputs = PublisherConflicts(node, ("command", "state"), health)
    assert inputs.update() == ""
    node.writers = {"command": ("pid_2", "pid"), "state": ("mocap_filter",)}
    assert inputs.update() == inputs.update() == TWO
    assert list(health.doubts.values()) == [TWO, ""]
    assert node.lines == [TWO]
    node.writers = {"command": ("pid", "pid")}
    assert inputs.update() == TWO.replace("pid_2", "pid") + "; one that was killed counts until DDS drops it"
    node.writers = {"command": ("pid",)}
    assert inputs.update() == ""
    assert list(health.doubts.values()) == ["", ""]


def room_for(build: Callable[[SharedRoom], object], **given: object) -> SharedRoom:
    """Return a room with a node in it."""
    node = SharedRoom(**given)
    build(node)
    return node


@pytest.mark.parametrize(
    ("build", "given", "is_reported"),
    [
        (Simulator, {"pace": "live", "autostart": False}, True),
        (Player, {"bag": str(BAG), "autostart": False, "clock": True}, True),
        (Player, {"bag": str(BAG), "autostart": False}, False),
    ],
)
def test_two_clocks_are_reported_by_each_node_that_writes_one(
    build: Callable[[SharedRoom], object], given: dict[str, object], *, is_reported: bool
) -> None:
    node = room_for(build, **given)
    node.writers = {"/clock": ("bag_play", "simulator")}
    node.report()
    node.report()
    message = "/clock: 2 nodes write it (bag_play, simulator); 1 may: stop the others"
    assert node.lines.count(message) == int(is_reported)
    assert node.graded == ((Level.WARN, message) if is_reported else (Level.STALE, "no tick"))
    node.writers = {"/clock": ("simulator",)}
    node.report()
    assert node.graded == (Level.STALE, "no tick")


def is_idle(node: SharedRoom) -> bool:
    """Return whether a node reported that it had no tick, for whichever input, and nothing else."""
    level, summary = node.graded
    return level == Level.STALE and summary.startswith("no tick")


KILLED = "; one that was killed counts until DDS drops it"
TWICE = "{0}: 2 nodes write it ({1}, {1}); 1 may: stop the others" + KILLED
NAMESAKES = (
    "command: 2 nodes write it ({0}, {0}); each needs its own name and vehicles: stop the others" + KILLED
)


@pytest.mark.parametrize(
    ("build", "topic"),
    [
        (mocap_filter_node.build, "state"),
        (interference_node.build, "interference"),
        (trajectory_node.build, "reference"),
        (trajectory_node.build, "plan"),
        (replanner_node.build, "reference_safe"),
        (pid_node.build, "command"),
        (mpc_node.build, "command"),
        (Player, "mocap"),
    ],
)
def test_a_node_that_runs_twice_reports_that_its_output_conflicts(
    build: Callable[[SharedRoom], object], topic: str, tmp_path: Path
) -> None:
    plan_file.save(tmp_path / "plan.json", flight_blocks.plan_of(library.load("table6")))
    given: dict[str, object] = {"bag": str(BAG), "autostart": False, "plan": str(tmp_path / "plan.json")}
    node = room_for(build, **given, vehicles=())
    node.writers = {topic: ("one",)}
    node.report()
    assert is_idle(node)
    node.writers = {topic: ("one", "one")}
    node.report()
    assert node.graded == (Level.WARN, TWICE.format(topic, "one"))


def test_controllers_of_some_vehicles_each_share_the_command_unless_they_have_one_name() -> None:
    node = room_for(pid_node.build, vehicles=("cf1",))
    for writers, namespaces, message in (
        (("pid", "pid_2", "pid_3"), ("/", "/", "/"), ""),
        (("pid", "pid"), ("/cf1", "/cf2"), ""),
        (("pid", "pid"), ("/", "/"), NAMESAKES.format("pid")),
        (("pid", "pid"), ("/cf1", "/cf1"), NAMESAKES.format("cf1/pid")),
    ):
        node.writers, node.namespaces = {"command": writers}, namespaces
        node.report()
        assert node.graded == (Level.WARN, message) if message else is_idle(node)


def test_the_simulator_reports_of_controllers_that_cannot_each_have_vehicles_of_their_own() -> None:
    node = room_for(Simulator, scenario="table6", pace="live", autostart=False)
    node.writers = {"command": ("pid", "pid")}
    node.report()
    assert node.graded == (Level.WARN, NAMESAKES.format("pid"))
    node.writers = {"command": ("mpc_cf1", "mpc_cf2")}
    node.report()
    assert node.graded == (Level.STALE, "no tick")


def test_a_report_of_writers_hides_nothing_that_a_node_doubts_of_the_same_topic() -> None:
    node = room_for(mocap_filter_node.build, vehicles=("cf1",))
    for k in range(60):  # what is wrong with frames is reported once it lasts
        frame = MocapFrame(0.01 * k, ("cf1",), np.full((1, 3), 1000.0 + k), identity_quat((1,)))
        node.takers["mocap"](encode(frame, 10**7 * k))
    node.report()
    assert node.graded[0] == Level.WARN
    assert node.graded[1].startswith("positions beyond pos_max rejected: cf1")


def commands(*orders: tuple[Names, float]) -> list[bytes]:
    """Return the commands of a second by controllers, each with its vehicles and their thrust [N]."""
    made = []
    for stamp_ns in range(0, 10**9, 10**7):
        for names, thrust in orders:
            level = np.zeros(len(names))
            one = level_command(0.0, names, level + thrust)
            made.append(encode(one, stamp_ns))
    return made


def test_the_simulator_names_the_vehicles_that_two_controllers_command_once() -> None:
    node = room_for(Simulator, scenario="table6", pace="live", autostart=False)
    node.writers = {"command": ("mpc", "pid")}
    message = "command: two nodes fly cf2: stop one, or give each its own `vehicles` (mpc, pid write it)"
    for orders, found in (
        ([(("cf1",), 0.2), (("cf2",), 0.3)], ""),
        ([(NAMES, 0.2), (("cf2",), 0.3)], message),
        ([(NAMES, 0.2), (("cf2",), 0.3)], message),
        ([(NAMES, 0.2), (("cf2",), 0.2)], ""),
    ):
        for data in commands(*orders):
            node.takers["command"](data)
        node.report()
        assert node.graded == ((Level.WARN, found) if found else (Level.STALE, "no tick"))
    assert node.lines == [message]


def test_a_bag_played_into_a_running_stack_is_reported_by_its_player() -> None:
    node = room_for(Player, bag=str(BAG), autostart=False)
    node.writers = {"mocap": ("bag_play",), "state": ("bag_play", "mocap_filter"), "other": ("a", "b")}
    node.report()
    message = "state: 2 nodes write it (bag_play, mocap_filter); 1 may: stop the others"
    assert node.graded == (Level.WARN, message)


@pytest.mark.parametrize(("topic", "build"), [("model", interference_node.build), ("plan", mpc_node.build)])
def test_two_publishers_of_models_or_plans_are_reported_each_second(
    topic: str, build: Callable[[RoomNode], TickWiring[Signal]]
) -> None:
    node = SharedRoom(model="none", vehicles=())
    wiring = build(node)
    node.writers = {topic: ("one", "two")}
    node.report()
    message = f"{topic}: 2 nodes write it (one, two); 1 may: stop the others"
    assert message in wiring.health.doubts.values()
    assert node.lines[0] == message
