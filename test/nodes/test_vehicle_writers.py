"""Time at which the publishers of vehicles are made: before flight if known, else one vehicle per tick."""

from dataclasses import dataclass, field

import pytest
from geometry_msgs.msg import PoseStamped, Twist

from q2q_model.ros.topics.vehicle_publishers import VehiclePublishers

TOPICS = {"pose": PoseStamped, "speed": Twist}
RATE_HZ = 10.0


@dataclass
class Writer:
    """Stand in for a publisher with so many readers."""

    readers: int = 0

    def get_subscription_count(self) -> int:
        """Answer as rclpy's."""
        return self.readers


@dataclass
class Node:
    """Note what publishers are made."""

    made: dict[str, Writer] = field(default_factory=dict)

    def create_publisher(self, _: type, topic: str, __: int) -> Writer:
        """Make a writer; two of one topic are a mistake."""
        assert topic not in self.made
        return self.made.setdefault(topic, Writer())


@pytest.fixture
def node() -> Node:
    return Node()


def test_those_of_known_vehicles_are_there_before_the_first_tick(node: Node) -> None:
    VehiclePublishers(node, TOPICS, RATE_HZ, ("cf1", "cf2"))
    assert list(node.made) == ["cf1/pose", "cf1/speed", "cf2/pose", "cf2/speed"]


def test_those_of_others_are_made_one_vehicle_a_tick(node: Node) -> None:
    writers, counts = VehiclePublishers(node, TOPICS, RATE_HZ, ("cf1",)), []
    for names in (("cf1",), *(("cf1", "cf2", "cf3"),) * 4, ("cf3", "cf4")):
        writers.create_next(names)
        counts.append(len(node.made))
    assert counts == [2, 4, 6, 6, 6, 8]


def test_only_vehicles_that_somebody_reads_are_published(node: Node) -> None:
    writers = VehiclePublishers(node, TOPICS, RATE_HZ, ("cf1", "cf2"))
    assert writers.with_subscribers("cf1", 0) == writers.with_subscribers("stranger", 0) == ()
    node.made["cf2/speed"].readers = 1
    assert writers.with_subscribers("cf2", 0) == (node.made["cf2/pose"], node.made["cf2/speed"])


def due(writers: VehiclePublishers, ticks: range, names: tuple[str, ...] = ("cf1",)) -> list[int]:
    """Return at which ticks of 10 ms they are due."""
    return [k for k in ticks if writers.due(0.01 * k, 10_000_000 * k, names)]


def test_vehicles_are_due_at_most_so_often_and_none_at_a_rate_of_zero(node: Node) -> None:
    writers = VehiclePublishers(node, TOPICS, RATE_HZ, ("cf1",))
    node.made["cf1/speed"].readers = 1
    assert due(writers, range(21)) == [0, 10, 20]
    none = VehiclePublishers(silent := Node(), TOPICS, 0.0, ("cf1",))
    assert due(none, range(21), ("cf1", "cf2")) == []
    assert silent.made == {}


def test_vehicles_that_nobody_reads_are_not_due_until_somebody_does(node: Node) -> None:
    writers = VehiclePublishers(node, TOPICS, RATE_HZ)
    assert due(writers, range(21)) == []
    assert list(node.made) == ["cf1/pose", "cf1/speed"]
    node.made["cf1/pose"].readers = 1
    assert due(writers, range(21, 71)) == [50, 60, 70]  # asked every half second
