"""Recorded flights in Python: what the command line notes is a warning."""

from pathlib import Path

import numpy as np
import pytest

import q2q
from q2q_model.bag import BagError, BagWriter, FlightFacts
from q2q_model.signals.values import MocapFrame

LEVEL = np.array([[0.0, 0.0, 0.0, 1.0]])


def turned_bag(path: Path) -> Path:
    """Write a circle 1 m above the floor in a frame whose z is down."""
    with BagWriter(path) as bag:
        for tick, angle in enumerate(np.linspace(0.0, 2.0 * np.pi, 200)):
            pos = np.array([[np.cos(angle), np.sin(angle), -1.0]])
            bag.write_signal("/mocap", 10_000_000 * tick, MocapFrame(0.01 * tick, ("cf1",), pos, LEVEL))
    return path


def test_a_flight_whose_z_seems_to_be_down_is_a_warning(tmp_path: Path) -> None:
    bag = turned_bag(tmp_path / "turned")
    with pytest.warns(UserWarning, match=r"flight turned: z is below -0.1 m in 100% .*: z may be down"):
        q2q.read_bag(bag, "crazyflie_2_0")
    with (
        pytest.warns(UserWarning, match=r"flight turned: z is below -0.1 m in 100% .*: z may be down"),
        pytest.raises(ValueError, match="reference"),  # it has none
    ):
        q2q.identify(bag, vehicle="crazyflie_2_0")


TOPICS = """signals: {mocap: /room/frames}"""


def test_a_bag_of_other_topics_is_read_by_a_topic_map_and_can_be_drawn(tmp_path: Path) -> None:
    """Its states are those of the filter: a circle of 1 m around the origin, 1 m up."""
    bag, of_room = tmp_path / "room", tmp_path / "room.yaml"
    of_room.write_text(TOPICS)
    with BagWriter(bag, facts=FlightFacts(vehicle="crazyflie_2_0")) as writer:
        for tick, angle in enumerate(np.linspace(0.0, 2.0 * np.pi, 400)):
            pos = np.array([[np.cos(angle), np.sin(angle), 1.0]])
            writer.write_signal(
                "/room/frames", 10_000_000 * tick, MocapFrame(0.01 * tick, ("cf1",), pos, LEVEL)
            )
    with pytest.raises(BagError, match=r"it has /room/frames, which a topic map assigns .*in Python topics="):
        q2q.read_bag(bag)
    flight = q2q.read_bag(bag, topics=of_room)
    np.testing.assert_allclose(np.hypot(*flight.arrays.pos[50:, 0, :2].T), 1.0, atol=0.01)  # 16 mm a tick
    assert flight.plot("altitude").axes


def test_a_bag_without_topics_is_said_to_have_none(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "empty", facts=FlightFacts(vehicle="crazyflie_2_0")):
        pass
    with pytest.raises(BagError, match=r"has no message on mocap; it has none$"):
        q2q.read_bag(tmp_path / "empty")


def test_tables_are_read_as_bags_are(tmp_path: Path) -> None:
    """The identification gets as far as in a bag without references."""
    table, t = tmp_path / "hover.csv", 0.01 * np.arange(400)
    rows = np.column_stack([t, 0.0 * t, 0.0 * t, 1.0 + 0.1 * np.sin(t)])
    np.savetxt(table, rows, delimiter=",", header="t,x,y,z", comments="")
    with pytest.raises(ValueError, match=r"topics applies to bags, but .*hover.csv is a table: leave out"):
        q2q.read_bag(table, "crazyflie_2_1", topics=tmp_path / "room.yaml")
    flight = q2q.read_bag(table, "crazyflie_2_1")
    assert (flight.names, flight.vehicle.name) == (("cf1",), "crazyflie_2_1")
    np.testing.assert_array_equal(flight.arrays.mocap_pos[:, 0], rows[:, 1:])
    with pytest.raises(ValueError, match="reference"):
        q2q.identify(tmp_path, vehicle="crazyflie_2_0")
