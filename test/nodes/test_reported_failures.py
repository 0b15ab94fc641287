"""What a node logs, and grades its health by, when vehicles are cut, alone or commanded by two nodes."""

import math
import socket
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from room_node import RoomNode, Writer
from std_srvs.srv import Empty

from q2q_control.ros import pid_node
from q2q_model.diagnostics.health import Health, HealthReport, Level, health_report
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.node.diagnostics_publisher import MOST_WARNINGS
from q2q_model.ros.node.publisher_conflicts import TopicConflict
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.stamps import stamp_from_time
from q2q_model.signals.values import CommandStatus, MocapFrame, SwarmCommand, SwarmSetpoint, SwarmState
from q2q_model.trajectory import plan_file
from q2q_planner.ros import trajectory_node
from q2q_sim.loop import flight_blocks
from q2q_sim.ros import simulator_node
from q2q_sim.ros.simulator_node import Simulator
from q2q_sim.scenarios import library

CUT = "motors cut by all/emergency: restart this node to fly"
LOST = (
    "motors cut after cut_after_s without measurements: "
    "to fly, restart this node or set stamps back by more than 1 s"
)


def controller(**given: object) -> tuple[RoomNode, TickWiring[SwarmCommand]]:
    """Return a PID node without downwash, and its wiring."""
    node = RoomNode("pid", {"aware": False, **given}, {})
    return node, pid_node.build(node)


def fly(node: RoomNode, first: float, last: float, lost_since: float = math.inf) -> None:
    """Give the node the ticks of these times [s]; the first vehicle was last seen at `lost_since` [s]."""
    for k in range(round(100 * first), round(100 * last)):
        t = 0.01 * k
        state = synthetic_signal(SwarmState, t, unseen=t > lost_since)
        if isinstance(state, SwarmState):
            state.age[0] = max(t - lost_since, 0.0)
        node.takers["state"](encode(state, stamp_from_time(t)))
        node.takers["reference_safe"](encode(synthetic_signal(SwarmSetpoint, t), stamp_from_time(t)))


def emergency(node: RoomNode) -> None:
    """Call all/emergency."""
    node.services["all/emergency"].ask(Empty.Request(), Empty.Response())


def graded(wiring: TickWiring[SwarmCommand]) -> HealthReport:
    """Return the grade of the node's life."""
    return health_report(Health(), wiring.health)


def test_an_emergency_is_one_error_line_at_once_and_an_error_of_health() -> None:
    node, wiring = controller()
    fly(node, 0.0, 2.0)
    assert (node.lines, graded(wiring).level) == ([], Level.OK)
    emergency(node)
    assert node.lines == [CUT]
    fly(node, 2.0, 2.2)
    assert node.lines == [CUT]
    assert (graded(wiring).level, graded(wiring).summary) == (Level.ERROR, CUT)
    fly(node, 0.0, 0.2)  # a simulator started again
    assert node.lines == [CUT, f"cf1, cf2: {CUT}"]


def test_an_emergency_before_the_first_tick_is_reported_as_well() -> None:
    node, wiring = controller()
    emergency(node)
    assert (node.lines, graded(wiring).summary) == ([CUT], CUT)


def test_a_lost_vehicle_is_reported_phase_by_phase_and_its_cut_is_an_error() -> None:
    node, wiring = controller()
    fly(node, 0.0, 0.5)
    fly(node, 0.5, 2.0, lost_since=0.5)
    assert graded(wiring).summary == "in fallback: cf1: failsafe LAND"
    fly(node, 2.0, 6.5, lost_since=0.5)
    assert node.lines == [
        "cf1: failsafe HOLD",
        "cf1: failsafe LEVEL",
        "cf1: failsafe LAND",
        f"cf1: {LOST}",
    ]
    assert (graded(wiring).level, graded(wiring).summary) == (Level.ERROR, node.lines[-1])


@pytest.mark.parametrize(("back", "flies"), [(0.9, False), (1.1, True)])
def test_a_vehicle_cut_for_want_of_measurements_flies_again_when_it_is_said_to(
    back: float, flies: bool
) -> None:
    node, wiring = controller(cut_after_s=1.5)
    fly(node, 0.0, 2.2, lost_since=0.5)
    first = 2.19 - back
    fly(node, first, first + 0.2)
    command = decode(node.published["command"][-1], SwarmCommand)
    assert (bool(command.thrust[0] > 0.0), command.status[0] != CommandStatus.CUT) == (flies, flies)
    assert wiring.health.failure == ("" if flies else f"cf1: {LOST}")


def test_packets_that_vehicles_refuse_are_a_doubt_of_the_simulator_while_they_come() -> None:
    node = RoomNode("simulator", {"crtp": True, "crtp_port": 0, "autostart": False}, {})
    simulator = Simulator(node)
    name, _, port = node.lines[0].replace(" listens at udp://127.0.0.1:", " ").partition(" ")
    doubts = []
    with closing(simulator), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(60.0)
        client.connect(("127.0.0.1", int(port)))
        for refused in (0, 2, 0):
            for datagram in (*[b"\xac\x00"] * refused, b"\xff"):
                client.send(datagram)
            assert client.recv(64) == b"\xff"  # the probe is answered after what came before
            simulator._diagnostics()
            doubts.append(health_report(Health(), simulator._flight.health).summary)
    assert doubts == ["no tick", f"CRTP of {name}: packets refused: 2 (port 10: not served)", "no tick"]


def test_a_trajectory_node_logs_at_which_stamp_its_plan_begins(tmp_path: Path) -> None:
    plan_file.save(tmp_path / "plan.json", flight_blocks.plan_of(library.load("table6")))
    node = RoomNode("trajectory", {"plan": str(tmp_path / "plan.json")}, {})
    trajectory_node.build(node)
    assert node.lines == []
    for t in (3.25, 3.26):
        node.takers["mocap"](encode(synthetic_signal(MocapFrame, t), stamp_from_time(t)))
    assert node.lines == ["the plan begins at stamp 3.250 s"]


def test_a_simulator_in_lockstep_warns_once_of_the_command_that_it_waits_for_and_of_giving_it_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wall = [0.0]
    monkeypatch.setattr(simulator_node, "perf_counter", lambda: wall[0])
    node = RoomNode("simulator", {"autostart": False, "command_timeout_s": 8.0}, {})
    simulator = Simulator(node)
    node.services["start"].call()
    summaries = []
    for wall[0] in (0.5, 1.5, 2.5):
        simulator._diagnostics()
        summaries.append(health_report(Health(), simulator._flight.health).summary)
    awaited = "command of cf1, cf2 not received: check that a controller runs"
    assert summaries == ["no tick", f"no tick: {awaited}", f"no tick: {awaited}"]
    assert node.lines == [awaited]
    for wall[0] in (8.0, 13.0, 18.0):
        simulator._on_timer()
    gave_up = "no command in 8 s (`command_timeout_s`): the vehicles fly without one, a tick every 5 s"
    assert node.lines == [awaited, gave_up]
    stamped = encode(synthetic_signal(SwarmCommand, 0.0), 1_796_034_108_352_000_000)
    node.takers["command"](stamped)
    simulator._diagnostics()
    simulator._diagnostics()
    foreign = (
        "command: a command is stamped 1796034108.352 s, its frame 0.030 s: stamp each with its frame's stamp"
    )
    assert node.lines == [awaited, gave_up, foreign]
    assert health_report(Health(), simulator._flight.health).summary == f"missing ticks; {foreign}"


@dataclass
class Graph:
    """Node that knows who writes a topic, and keeps what it warns of."""

    writers: list[str]
    lines: list[str] = field(default_factory=list)

    def resolve_topic_name(self, topic: str) -> str:
        """Return the topic in the room that every topic is remapped into."""
        return f"/room/{topic}"

    def count_publishers(self, topic: str) -> int:
        """Return how many write a topic."""
        return len(self.get_publishers_info_by_topic(topic))

    def get_publishers_info_by_topic(self, topic: str) -> list[Writer]:
        """Return who writes a topic of the room."""
        return [Writer(name) for name in self.writers if topic.startswith("/room/")]

    def get_logger(self) -> "Graph":
        """Return the node itself, which keeps the lines."""
        return self

    def warning(self, line: str) -> None:
        """Keep a line."""
        self.lines.append(line)


def test_a_second_writer_of_an_input_is_reported_once_and_graded_until_it_is_gone() -> None:
    graph, health = Graph(["replanner"]), Health()
    writers = TopicConflict(graph, "reference_safe")
    message = "reference_safe: 2 nodes write it (replanner, replanner_2); 1 may: stop the others"
    for names, found in ((1, ""), (2, message), (2, message), (1, ""), (2, message)):
        graph.writers[:] = ["replanner_2", "replanner"][-names:]
        health.ticks, health.doubts["reference_safe"] = 5, writers.update()
        assert health.doubts["reference_safe"] == found
        after = health_report(Health(), health)
        assert (after.level, after.summary) == ((Level.WARN, message) if found else (Level.OK, "5 ticks"))
    assert graph.lines == [message]


def test_the_vehicle_that_stays_without_a_state_is_named_after_the_others_came_one_by_one() -> None:
    vehicles = tuple(f"cf{k:02d}" for k in range(2 * MOST_WARNINGS))
    node, wiring = controller()
    node.takers["reference_safe"](encode(synthetic_signal(SwarmSetpoint, 0.0, vehicles), 0))
    for count in range(1, len(vehicles)):
        state = synthetic_signal(SwarmState, 0.01 * count, vehicles[:count])
        node.takers["state"](encode(state, stamp_from_time(0.01 * count)))
    assert f"{vehicles[-1]} not in state, which has cf00, cf01" in graded(wiring).summary
    whole = synthetic_signal(SwarmState, 1.0, vehicles)
    node.takers["state"](encode(whole, stamp_from_time(1.0)))
    assert "not in state" not in graded(wiring).summary
    assert sum("not in state" in line for line in node.lines) == MOST_WARNINGS
