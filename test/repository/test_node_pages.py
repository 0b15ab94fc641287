"""Pages of nodes, the table of signals, and parameters in documented commands are what the nodes declare."""

from pathlib import Path

import pytest
import yaml
from documentation import commands
from fresh_checkout import ROOT

from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.tunable import tunable_of
from q2q_sim.commands.node_pages import OUT
from q2q_sim.flight_bag.topics import LATCHED_TYPES, is_latched
from q2q_sim.ros.node_survey import NodeInterface, survey
from q2q_sim.tools.docs.write_node_pages import out_of_date, pages, table

OF_EVERY_TOPIC = ("bag_record", "bag_play")
"""Nodes that read topics of any name."""


@pytest.fixture(scope="module")
def nodes() -> list[NodeInterface]:
    return survey()


def test_the_node_pages_are_what_the_nodes_declare(nodes: list[NodeInterface]):
    assert out_of_date(pages(nodes), ROOT / OUT) == [], "run scripts/node_pages"


def test_a_page_reports_every_field_of_the_parameters_with_unit_and_bounds(nodes: list[NodeInterface]):
    page = pages(nodes)["mocap_filter.md"]
    for field in MocapFilterParams.__dataclass_fields__.values():
        row = next(line for line in page.splitlines() if line.startswith(f"| `{field.name}` |"))
        spec = tunable_of(field)
        assert f"`{field.default}`" in row
        assert f"[{spec.unit}]" in row
        assert f"{spec.low:g}" in row


def test_what_a_node_publishes_for_a_vehicle_is_on_its_page(nodes: list[NodeInterface]):
    ports = {node.executable: {port.name for port, _ in node.ports} for node in nodes}
    assert {"state", "mocap", "<name>/pose", "<name>/odom"} <= ports["mocap_filter"]
    assert {"command", "state", "reference_safe", "interference", "<name>/cmd_vel_legacy"} <= ports["pid"]


def test_the_player_knows_every_topic_that_a_node_latches(nodes: list[NodeInterface]):
    topics = [port for node in nodes for port, _ in node.ports if port.direction in {"publishes", "reads"}]
    latched = {port for port in topics if "transient local" in port.quality}
    assert {(port.name.rpartition("/")[2], port.kind) for port in latched} == set(LATCHED_TYPES.items())
    assert not [port for port in topics if is_latched(port.name, port.kind) and port not in latched]


def test_a_topic_that_takes_a_parameter_says_which(nodes: list[NodeInterface]):
    pid = next(node for node in nodes if node.executable == "pid")
    when = {port.name: words for port, words in pid.ports}
    assert when["interference"] == "`aware`: true"
    assert when["state"] == ""


def test_a_parameter_that_takes_another_says_which(nodes: list[NodeInterface]):
    needs = {(node.executable, one.declared.name): one.requires for node in nodes for one in node.parameters}
    assert needs["pid", "latency"] == "`correct`: true"
    assert needs["pid", "k_p_z"] == ""
    assert needs["mpc", "latency"] == ""
    assert needs["replanner", "eps"] == "`law`: paper"
    assert needs["replanner", "safe.eps"] == "`law`: safe"
    assert needs["simulator", "crtp_port"] == "`crtp`: true"


def test_a_value_that_only_stands_for_any_other_is_not_named(nodes: list[NodeInterface]):
    when = {
        (node.executable, port.name, port.direction): words for node in nodes for port, words in node.ports
    }
    assert when["interference", "imu", "reads"] == "`correct_vehicle`: not none"
    assert when["crazyswarm", "/poses_filtered", "publishes"] == "`poses_out`: not empty"


def test_only_parameters_that_the_node_heeds_may_change_in_flight(nodes: list[NodeInterface]):
    heeded = {
        (node.executable, one.declared.name): one.settable and not one.declared.read_only
        for node in nodes
        for one in node.parameters
    }
    assert heeded["pid", "k_p_z"]
    assert not heeded["pid", "vehicle"]
    assert not heeded["simulator", "seed"]


def test_a_page_that_is_missing_changed_or_of_no_node_is_out_of_date(tmp_path: Path):
    (tmp_path / "same.md").write_text("a")
    (tmp_path / "changed.md").write_text("b")
    (tmp_path / "left.md").write_text("c")
    expected = {"same.md": "a", "changed.md": "B", "missing.md": "d"}
    assert out_of_date(expected, tmp_path) == ["changed.md", "left.md", "missing.md"]


def test_a_bar_in_a_cell_does_not_end_it():
    assert table(("a", "b"), [("|x|", "y")]).splitlines()[2] == r"| \|x\| | y |"


def test_the_table_of_signals_names_every_node_that_reads_one(nodes: list[NodeInterface]):
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = page.partition("## Signals")[2].partition("\n## ")[0]
    rows = [line.split(" | ") for line in section.splitlines()]
    to = {cells[0].strip("| `"): cells[3] for cells in rows if len(cells) == 4}
    read = {
        (port.name, node.executable)
        for node in nodes
        for port, _ in node.ports
        if port.direction == "reads" and node.executable not in OF_EVERY_TOPIC
    }
    assert {"mocap", "state", "command", "imu"} <= to.keys()
    assert {(topic, node) for topic, node in read if topic in to and node not in to[topic]} == set()


def test_every_parameter_that_a_command_sets_is_declared_and_of_its_type(nodes: list[NodeInterface]):
    declared = {
        (node.package, node.executable): {one.declared.name: one.declared for one in node.parameters}
        for node in nodes
    }
    for command in (one for one in commands() if one.program[0] == "ros2"):
        for name, value in command.parameters.items():
            default = declared[command.words[2], command.words[3]][name].default
            plain = yaml.safe_load(value)
            if isinstance(default, bool | int | float | str):  # an empty list has no type of its own
                assert isinstance(plain, type(default)), f"{command.where}: {name}"
