"""The recorder keeps what a busy machine lets it read late, and what was latched or sent best effort."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from serialized_commands import serialized_at

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from q2q_msgs.msg import SwarmCommand
from rclpy.context import Context
from rclpy.exceptions import NameValidationException
from rclpy.node import Node
from rosbags.interfaces import QosReliability
from rosbags.rosbag2 import Reader
from spun_until import spin_until
from std_msgs.msg import String

from q2q_model.bag import BagReader
from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.topics.qos import LATCHED, OUTSIDE, TICK_WRITER
from q2q_sim.processes.domain import own_domain
from q2q_sim.ros.bag_record_node import Recorder

SENT = 3000
"""Half a minute of a topic at 100 Hz, before the first is read."""


@contextmanager
def recording(bag: Path, *parameters: str) -> Iterator[Node]:
    """Yield a node with the parameters of a recorder of `bag`."""
    given = [word for one in (f"bag:={bag}", *parameters) for word in ("-p", one)]
    with own_domain():
        rclpy.init(args=["--ros-args", *given])
        node = Node("bag_record")
        try:
            yield node
        finally:
            node.destroy_node()
            rclpy.try_shutdown()


def test_messages_that_are_read_late_are_all_in_the_bag(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bag = tmp_path / "bag"
    with recording(bag, "topics:=[command]") as late:
        recorder, writing = Recorder(late), Node("writing")
        executor = make_executor()
        executor.add_node(late)
        writer = writing.create_publisher(SwarmCommand, "command", TICK_WRITER)
        spin_until(executor, lambda: writer.get_subscription_count() > 0, "the recorder's subscription")
        for _ in range(SENT):
            writer.publish(SwarmCommand())
        health = recorder.bag.health
        spin_until(executor, lambda: health.ticks + health.missed >= SENT, f"{SENT} messages")
        recorder.close()
        writing.destroy_node()
    assert sum(1 for _ in BagReader(bag).raw()) == SENT
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("topic", ["poses", "command"])
def test_what_a_driver_sends_best_effort_is_recorded_as_such(tmp_path: Path, topic: str) -> None:
    bag = tmp_path / "bag"
    extra = ["extra:=['poses:q2q_msgs/msg/SwarmCommand']"] if topic == "poses" else []
    with recording(bag, *extra) as node:
        recorder, writing = Recorder(node), Node("writing")
        executor = make_executor()
        executor.add_node(node)
        writer = writing.create_publisher(SwarmCommand, topic, OUTSIDE)

        def is_heard() -> bool:
            writer.publish(SwarmCommand())
            return recorder.bag.health.ticks > 0

        spin_until(executor, is_heard, "a best-effort message")
        recorder.close()
        writing.destroy_node()
    assert [one.topic for one in BagReader(bag).raw()][:1] == [f"/{topic}"]
    with Reader(bag) as stored:
        [channel] = [one for one in stored.connections if one.topic == f"/{topic}"]
        assert [one.reliability for one in channel.ext.offered_qos_profiles] == [QosReliability.BEST_EFFORT]


def test_a_topic_that_is_published_with_another_type_is_named_with_both(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with recording(tmp_path / "bag", "topics:=[command]") as node:
        other = Context()  # one participant has one type for each topic
        rclpy.init(context=other)
        recorder, writing = Recorder(node), Node("writing", context=other)
        executor = make_executor()
        executor.add_node(node)
        writing.create_publisher(String, "command", OUTSIDE)
        spin_until(executor, lambda: bool(recorder.bag.other_types), "the other type")
        rclpy.shutdown(context=other)
        recorder.close()
    said = "/command is published as std_msgs/msg/String, not as q2q_msgs/msg/SwarmCommand"
    assert f"bag_record: {said}: it is not recorded\n" in (error := capfd.readouterr().err)
    assert "check that their nodes run" not in error


LATCHED_EXTRA = "extra:=['map:q2q_msgs/msg/SwarmCommand']"
"""A latched topic of other software; any type of message will do."""


@pytest.mark.parametrize("is_late", [True, False])
def test_what_was_latched_before_and_after_the_recorder_began_is_recorded_once(
    tmp_path: Path, *, is_late: bool
) -> None:
    bag, sent = tmp_path / "bag", [serialized_at(1), serialized_at(2)]
    with recording(bag, LATCHED_EXTRA) as node:
        writing = Node("writing")
        executor = make_executor()
        executor.add_node(node)
        recorder = None if is_late else Recorder(node)
        writer = writing.create_publisher(SwarmCommand, "map", LATCHED)
        writer.publish(sent[0])
        recorder = recorder or Recorder(node)
        health = recorder.bag.health
        spin_until(executor, lambda: health.ticks > 0, "the first message")
        writer.publish(sent[1])
        spin_until(executor, lambda: health.ticks >= len(sent), "the second message")
        recorder.close()
        writing.destroy_node()
    assert [bytes(one.data) for one in BagReader(bag).raw()] == sent
    assert BagReader(bag).latched == {"/map"}


def test_a_latched_topic_is_recorded_on_once_a_writer_joins_that_does_not_latch_it(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    with recording(bag, LATCHED_EXTRA) as node:
        recorder, writing = Recorder(node), Node("writing")
        executor = make_executor()
        executor.add_node(node)
        latching = writing.create_publisher(SwarmCommand, "map", LATCHED)
        latching.publish(serialized_at(1))
        spin_until(executor, lambda: recorder.bag.health.ticks > 0, "the latched message")
        other = writing.create_publisher(SwarmCommand, "map", TICK_WRITER)
        both = (latching, other)
        spin_until(executor, lambda: all(one.get_subscription_count() for one in both), "two subscriptions")
        for writer, second in ((latching, 2), (other, 3)):
            writer.publish(serialized_at(second))
        spin_until(executor, lambda: recorder.bag.health.ticks >= 3, "three messages")
        recorder.close()
        writing.destroy_node()
    stored = [bytes(one.data) for one in BagReader(bag).raw()]
    assert sorted(stored) == [serialized_at(second) for second in (1, 2, 3)]


REFUSED = (
    "'/two words:std_msgs/msg/String'",
    "'/words:std_msgs/msg/Nope'",
    "'words'",
    "'/words:std_msgs/msg/String', 'words:std_msgs/msg/Int32'",
    "'/state:q2q_msgs/msg/SwarmState'",
)
"""Values of `extra`; the last is recorded already."""


@pytest.mark.parametrize("extra", REFUSED)
def test_a_recorder_that_is_refused_leaves_no_folder(tmp_path: Path, extra: str) -> None:
    bag = tmp_path / "bag"
    refused = (ValueError, NameValidationException)
    with recording(bag, f"extra:=[{extra}]") as node, pytest.raises(refused):
        Recorder(node)
    assert not bag.exists()
