"""Topics that are latched in flight are played latched: who comes late has the last message."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rclpy.node import Node
from spun_until import spin_until
from std_msgs.msg import String

from q2q_model.bag import BagReader, BagWriter, OfferedQos
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.topics.qos import LATCHED
from q2q_model.signals.values import MocapFrame
from q2q_sim.flight_bag.topics import LATCHED_TYPES
from q2q_sim.processes.domain import own_domain
from q2q_sim.ros.bag_play_node import Player
from q2q_sim.ros.bag_record_node import Recorder

STRING = "std_msgs/msg/String"
SENT = {"/model": (0.0, 1.0), "/room/model": (0.5,), "/map": (0.2,), "/words": (0.0, 1.5)}
"""Topic to the bag times of its messages [s]."""


def serialized(text: str) -> bytes:
    """Return the message of a text."""
    return b"\x00\x01\x00\x00" + (len(text) + 1).to_bytes(4, "little") + text.encode() + b"\x00"


def recorded(bag: Path) -> Path:
    """Write a bag of texts and two frames: those of `/model` are latched in flight, of `/map` in the bag."""
    texts = [(t, topic, serialized(f"{topic} at {t}")) for topic, times in SENT.items() for t in times]
    with BagWriter(bag) as writer:
        for topic in SENT:
            writer.add_topic(topic, STRING, OfferedQos(transient_local=topic == "/map"))
        for t, topic, data in sorted(texts):
            writer.write_raw(topic, round(t * 1e9), data)
        writer.write_signal("/mocap", 2_000_000_000, synthetic_signal(MocapFrame, 2.0, ("cf1",)))
    return bag


@contextmanager
def node_of(name: str, *given: str) -> Iterator[Node]:
    """Yield a node with these parameters, in a domain of its own."""
    with own_domain():
        rclpy.init(args=["--ros-args", *(word for one in given for word in ("-p", one))])
        node = Node(name)
        try:
            yield node
        finally:
            node.destroy_node()
            rclpy.try_shutdown()


def heard_late(playing: Node, topics: Mapping[str, int]) -> dict[str, list[str]]:
    """Return what a latched subscriber that comes now hears, until each topic has brought so many texts."""
    heard: dict[str, list[str]] = {topic: [] for topic in topics}
    late = Node("late")
    for topic, texts in heard.items():
        late.create_subscription(String, topic, lambda one, texts=texts: texts.append(one.data), LATCHED)
    executor = make_executor()
    executor.add_node(playing)
    executor.add_node(late)
    spin_until(
        executor,
        lambda: all(len(heard[topic]) >= count for topic, count in topics.items()),
        f"latched messages of {', '.join(topics)}",
    )
    late.destroy_node()
    return heard


def test_who_comes_late_has_the_last_message_of_each_latched_topic(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag")
    with node_of("bag_play", f"bag:={bag}", "autostart:=false") as node:
        player = Player(node)
        player._begin()
        for _ in range(sum(map(len, SENT.values()))):
            assert player._messages.next is not None
            player._play_next(player._messages.next)
        heard = heard_late(node, {"model": 1, "room/model": 1, "map": 1})
    assert heard == {
        "model": ["/model at 1.0"],
        "room/model": ["/room/model at 0.5"],
        "map": ["/map at 0.2"],
    }


def test_a_later_start_plays_what_was_latched_before_it(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag")
    with node_of("bag_play", f"bag:={bag}", "autostart:=false", "start:=1.2") as node:
        player = Player(node)
        player._begin()
        heard = heard_late(node, {"model": 1, "map": 1})
        assert player._messages.next is not None
        assert (player._messages.next.topic, player._messages.next.stamp_ns) == ("/words", 1_500_000_000)
    assert heard == {"model": ["/model at 1.0"], "map": ["/map at 0.2"]}


def test_the_recorder_writes_that_a_topic_is_latched_in_flight(tmp_path: Path) -> None:
    extra = [f"'{topic}:{kind}'" for topic, kind in LATCHED_TYPES.items()]
    with node_of("bag_record", f"bag:={tmp_path / 'bag'}", f"extra:=[{', '.join(extra)}]") as node:
        Recorder(node).close()
    assert BagReader(tmp_path / "bag").latched == {f"/{topic}" for topic in LATCHED_TYPES}
