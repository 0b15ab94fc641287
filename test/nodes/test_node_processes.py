"""Nodes as a user starts them: clean ends, and one clear line for every wrong input."""

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from time import monotonic

import pytest
import rclpy
from fresh_checkout import ROOT
from rclpy.node import Node
from started_nodes import TIMEOUT_S, start, wait_until_spinning
from std_msgs.msg import Empty

from q2q_model.vehicle.constants import VEHICLES
from q2q_sim.processes.domain import own_domain

INTERRUPTED = """
import os, signal, sys
from q2q_model.ros.node.run import run

def build(node):
    for _ in range(int(sys.argv[1])):
        os.kill(os.getpid(), signal.SIGINT)
    print("built")

run("node", build)
"""
"""Node that is interrupted while it is built, once or more often."""
FINISHED = """
from std_msgs.msg import Empty
from q2q_model.ros.node.run import finish, run

def build(node):
    node.create_subscription(Empty, "done", lambda _: finish(node), 1)

run("node", build)
"""
"""Node that ends by itself once it hears `done`."""
LANDING = """
import os, signal
from q2q_model.ros.node.run import run

def build(node):
    calls = []
    node.create_timer(0.01, lambda: calls.append(os.kill(os.getpid(), signal.SIGINT)))
    return calls

def land(calls):
    before.append(len(calls))
    return 0.0 if before[-1] >= before[0] + 5 else 60.0

before = []
run("node", build, lambda calls: print("down after 5 calls:", len(calls) >= before[0] + 5), land)
"""
"""Node that is interrupted at each call of its timer, and lands for five calls."""
OVERDUE = """
import os, signal
from time import monotonic
from q2q_model.ros.node.run import run

signal.signal(signal.SIGHUP, signal.SIG_DFL)  # as in a terminal, where a test under nohup ignores it

def build(node):
    calls = []
    def take_longer_than_the_period():
        calls.append(monotonic())
        while monotonic() - calls[-1] < 0.003:
            pass
        if len(calls) == 5:
            os.kill(os.getpid(), signal.{name})
    node.create_timer(0.001, take_longer_than_the_period)
    return calls

run("node", build, lambda calls: print("ended within 1 s:", calls[-1] - calls[4] < 1.0))
"""
"""Node with a timer whose callback takes longer than its period, ended at the fifth call."""
NO_HANG_UP = """
import os, signal
from q2q_model.ros.node.run import run

def build(node):
    calls = []
    def kill():
        calls.append(None)
        os.kill(os.getpid(), signal.SIGINT if len(calls) == 5 else signal.SIGHUP)
    node.create_timer(0.01, kill)
    return calls

signal.signal(signal.SIGHUP, signal.SIG_IGN)
run("node", build, lambda calls: print("called on:", len(calls) >= 5))
"""
"""Node started by nohup, that gets four SIGHUP, and then SIGINT."""
FOR_EVER = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com"><profiles>
  <participant profile_name="for_ever" is_default_profile="true"><rtps><builtin><discovery_config>
    <leaseDuration><sec>3600</sec></leaseDuration>
  </discovery_config></builtin></rtps></participant>
</profiles></dds>
"""
"""Fast DDS: a node that does not say that it leaves is believed to be there for an hour, not for 20 s."""
NODES = [
    ("q2q_model", "mocap_filter", []),
    ("q2q_model", "interference", []),
    ("q2q_planner", "replanner", []),
    ("q2q_control", "pid", []),
    ("q2q_sim", "simulator", ["autostart:=false"]),
]

MISSPELT = (
    ("q2q_sim", "simulator", ["scenaro:=1"], "scenario"),
    ("q2q_control", "pid", ["k_p_zz:=1"], "k_p_z"),
    ("q2q_sim", "stack", ["nodes:=[mocap_filter, replanner]", "law_:=1"], "law"),
)
"""The last one is of a node within the process."""


@pytest.fixture(autouse=True)
def domain(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with own_domain():
        yield


def ros_words(parameters: list[str]) -> list[str]:
    return ["--ros-args", *(word for parameter in parameters for word in ("-p", parameter))]


def refusal(package: str, executable: str, parameters: list[str]) -> str:
    process = start(package, executable, ros_words(parameters))
    _, lines = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 2, lines
    assert "Traceback" not in lines
    assert len(lines.strip().splitlines()) == 1, lines
    return lines


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(("package", "executable", "parameters"), NODES)
def test_a_node_ends_with_0_on_a_signal(
    package: str, executable: str, parameters: list[str], number: signal.Signals
) -> None:
    process = start(package, executable, ros_words(parameters))
    wait_until_spinning(process)
    process.send_signal(number)
    _, lines = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0, lines
    assert "Traceback" not in lines


@pytest.mark.parametrize(("times", "printed"), [(1, "built\n"), (2, "")])
def test_an_interrupt_while_a_node_is_built_ends_it_once_built_and_a_second_one_at_once(
    times: int, printed: str
) -> None:
    process = [sys.executable, "-c", INTERRUPTED, str(times)]
    done = subprocess.run(process, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, without_log(done.stderr)) == (0, printed, "")


def test_a_node_runs_on_when_its_terminal_closes_if_it_ignores_that() -> None:
    done = subprocess.run([sys.executable, "-c", NO_HANG_UP], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, without_log(done.stderr)) == (0, "called on: True\n", "")


def test_callbacks_run_on_while_a_node_lands() -> None:
    done = subprocess.run([sys.executable, "-c", LANDING], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, without_log(done.stderr)) == (0, "down after 5 calls: True\n", "")


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_node_with_a_timer_that_is_always_overdue_ends_on_a_signal(name: str) -> None:
    process = [sys.executable, "-c", OVERDUE.replace("{name}", name)]
    done = subprocess.run(process, capture_output=True, text=True, check=False, timeout=TIMEOUT_S)
    assert (done.returncode, done.stdout, without_log(done.stderr)) == (0, "ended within 1 s: True\n", "")


def test_a_node_that_ends_by_itself_reports_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "for_ever.xml").write_text(FOR_EVER)
    monkeypatch.setenv("FASTRTPS_DEFAULT_PROFILES_FILE", str(tmp_path / "for_ever.xml"))
    rclpy.init()
    try:
        node = Node("other")
        writer = node.create_publisher(Empty, "done", 1)
        process = subprocess.Popen([sys.executable, "-c", FINISHED])
        until(node, lambda: writer.get_subscription_count() == 1)
        writer.publish(Empty())
        assert process.wait(timeout=TIMEOUT_S) == 0
        until(node, lambda: writer.get_subscription_count() == 0)
    finally:
        rclpy.try_shutdown()


def without_log(lines: str) -> str:
    """Return the lines without those of the log, in which a node says that it runs."""
    return "".join(line for line in lines.splitlines(keepends=True) if not line.startswith("[INFO]"))


def until(node: Node, reached: Callable[[], bool]) -> None:
    """Let a node run until something is so."""
    deadline = monotonic() + TIMEOUT_S
    while not reached():
        assert monotonic() < deadline
        rclpy.spin_once(node, timeout_sec=0.05)


def test_an_unknown_scenario_is_answered_with_the_nearest_right_one() -> None:
    assert "table6" in refusal("q2q_sim", "simulator", ["scenario:=tabel6"])


@pytest.mark.parametrize(("package", "executable", "wrong", "right"), MISSPELT)
def test_a_parameter_there_is_not_is_answered_with_the_nearest_right_one(
    package: str, executable: str, wrong: list[str], right: str
) -> None:
    assert f"did you mean {right}?" in refusal(package, executable, wrong)


def test_a_parameter_of_every_ros_node_of_the_wrong_type_is_refused() -> None:
    lines = refusal("q2q_model", "mocap_filter", ["use_sim_time:=1"])
    expected = "'use_sim_time' to '1' of type 'INTEGER', expecting type 'BOOL'; give true or false\n"
    assert lines == f"mocap_filter: Trying to set parameter {expected}"


def test_bag_play_ends_when_the_bag_does() -> None:
    process = start("q2q_sim", "bag_play", ros_words([f"bag:={ROOT / 'bags/table2_1'}", "rate:=1000.0"]))
    _, lines = process.communicate(timeout=TIMEOUT_S)
    assert (process.returncode, without_log(lines)) == (0, "playback over\n")


def test_bag_play_plays_a_bag_of_others_by_a_topic_map(tmp_path: Path) -> None:
    given = [f"bag:={ROOT / 'bags/table2_1'}", "rate:=1000.0", f"topic_map:={tmp_path / 'map.yaml'}"]
    (tmp_path / "map.yaml").write_text("signals: {mocap: /mocap, reference: /no_such}")
    assert "no topic /no_such" in refusal("q2q_sim", "bag_play", given)
    (tmp_path / "map.yaml").write_text("signals: {mocap: /mocap}")
    process = start("q2q_sim", "bag_play", ros_words([*given, "topics:=[mocap]"]))
    _, lines = process.communicate(timeout=TIMEOUT_S)
    assert (process.returncode, without_log(lines)) == (0, "playback over\n")


def test_a_gain_out_of_range_is_refused_with_its_bounds() -> None:
    lines = refusal("q2q_control", "pid", ["k_p_z:=-3.0"])
    assert "k_p_z" in lines
    assert "-3" in lines
    assert "[0.0, 200.0]" in lines


def test_an_unknown_vehicle_is_refused_with_the_known_ones() -> None:
    lines = refusal("q2q_control", "pid", ["vehicle:=jumbo"])
    assert f"choose one of {', '.join(VEHICLES)}" in lines


def test_a_model_file_cut_in_half_is_refused_by_name(tmp_path: Path) -> None:
    from q2q_model.model_files.model_names import shipped_models

    whole = (shipped_models() / "paper_law.q2q").read_text()
    cut = tmp_path / "cut.q2q"
    cut.write_text(whole[: len(whole) // 2])
    assert "cut.q2q" in refusal("q2q_model", "interference", [f"model:={cut}"])


def test_a_nan_waypoint_is_refused_naming_vehicle_and_waypoint(tmp_path: Path) -> None:
    scenario = (Path(__file__).parents[1] / "scenarios" / "short_room.yaml").read_text()
    broken = tmp_path / "broken.yaml"
    broken.write_text(scenario.replace("[0.0, -0.6, 1.4]", "[.nan, -0.6, 1.4]"))
    lines = refusal("q2q_sim", "simulator", [f"scenario:={broken}"])
    assert "cf2" in lines
    assert "nan" in lines.lower()


def test_a_trajectory_without_a_plan_says_how_to_get_one() -> None:
    assert "plan" in refusal("q2q_planner", "trajectory", [])


def test_a_recorder_refuses_to_overwrite_a_bag(tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    assert "bag" in refusal("q2q_sim", "bag_record", [f"bag:={tmp_path / 'bag'}"])
