"""The report of a bag sums up what the nodes said of themselves."""

from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.serialization import serialize_message

from q2q_model.bag import BagError, BagWriter
from q2q_model.diagnostics.health import Level
from q2q_sim.flight_bag.recorded_diagnostics import TOPIC, recorded_lives


def bag_of(folder: Path, output: list[tuple[str, Level, str]]) -> Path:
    writer = BagWriter(folder / "bag")
    writer.add_topic(TOPIC, "diagnostic_msgs/msg/DiagnosticArray")
    for k, (name, level, rate) in enumerate(output):
        values = [KeyValue(key="rate_hz", value=rate), KeyValue(key="last_refusal", value="")]
        status = DiagnosticStatus(name=name, level=bytes([level]), values=values)
        writer.write_raw(TOPIC, k, serialize_message(DiagnosticArray(status=[status])))
    writer.close()
    return folder / "bag"


def test_a_node_is_as_bad_as_its_worst_second_and_reports_its_last_values(tmp_path: Path):
    output = [("/pid", Level.OK, "99"), ("/pid", Level.WARN, "80"), ("/pid", Level.STALE, "0")]
    (life,) = recorded_lives(bag_of(tmp_path, output))
    assert (life.node, life.seconds, life.warned, life.worst) == ("/pid", 3, 1, Level.WARN)
    assert life.values == "rate_hz 0"


def test_a_node_that_never_ticked_is_stale_and_nodes_are_sorted(tmp_path: Path):
    lives = recorded_lives(bag_of(tmp_path, [("/view", Level.STALE, "0"), ("/mpc", Level.ERROR, "5")]))
    assert [(life.node, life.worst) for life in lives] == [("/mpc", Level.ERROR), ("/view", Level.STALE)]


def test_a_bag_without_diagnostics_has_none(tmp_path: Path):
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/mocap", "q2q_msgs/msg/MocapFrame")
    writer.close()
    assert recorded_lives(tmp_path / "bag") == ()


def test_a_message_that_is_cut_is_named_with_its_time(tmp_path: Path):
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic(TOPIC, "diagnostic_msgs/msg/DiagnosticArray")
    writer.write_raw(TOPIC, 7, serialize_message(DiagnosticArray())[:12])
    writer.close()
    with pytest.raises(BagError, match="topic /diagnostics at 7 ns: no diagnostic_msgs/msg/DiagnosticArray"):
        recorded_lives(tmp_path / "bag")
