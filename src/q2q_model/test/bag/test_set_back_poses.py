"""Poses whose clock goes back: the last of equal stamps counts, and two flights in one bag are refused."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from mcap_ros2.writer import Writer
from message_definitions import HEADER, POSE
from resting_signals import resting_state

from q2q_model.bag import BagError, TopicMap, read_mapped_flight
from q2q_model.bag.foreign.pose_frames import Poses, clock_set_back, pose_frames
from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.signals.values import Array, SwarmState

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
FLIGHT = np.arange(500) / 100.0
"""Stamps of a flight of 5 s [s]."""


def _state(t: float, x: float) -> SwarmState:
    return resting_state(t, ("cf1",), np.full((1, 3), x))


def test_the_last_of_equal_stamps_counts_for_poses_as_for_signals() -> None:
    stamps = np.array([0.0, 0.01, 0.01, 0.01, 0.02])
    x = np.arange(5.0)
    track = Poses(stamps, np.repeat(x[:, None], 3, axis=1), np.tile(LEVEL, (5, 1)), 0.0)
    frames, repairs = pose_frames({"cf1": track}, 0.005)
    assert repairs == ["2 repeated stamps of poses of cf1: the last is used"]
    states = [_state(t, at) for t, at in zip(stamps, x, strict=True)]
    flight = flight_from_signals("made", {"mocap": frames, "state": states}).flight
    assert flight.mocap_pos[:, 0, 0].tolist() == [0.0, 3.0, 4.0]
    assert flight.pos[:, 0, 0].tolist() == [0.0, 3.0, 4.0]


@pytest.mark.parametrize("later", [FLIGHT, FLIGHT + 0.003, FLIGHT[:50] + 3.0])
def test_a_second_flight_on_a_clock_that_was_set_back_is_found(later: Array) -> None:
    found = clock_set_back(np.concatenate([FLIGHT, later]))
    assert found.startswith(
        f"after 500 of {500 + len(later)}, their stamps go back from 4.990 to {later[0]:.3f}"
    )


def _with(row: int, stamp: float) -> Array:
    changed = FLIGHT.copy()
    changed[row] = stamp
    return changed


def _late(count: int, rows: int) -> Array:
    """Return a flight of which some stamps in a row are recorded a number of rows late."""
    before, late, after = np.split(FLIGHT, [100, 100 + count])
    return np.concatenate([before, after[:rows], late, after[rows:]])


def test_a_clock_set_back_after_late_stamps_is_found_where_it_was_set_back() -> None:
    found = clock_set_back(np.concatenate([_late(3, 200), FLIGHT - 2.0]))
    assert found.startswith("after 500 of 1000, their stamps go back from 4.990 to -2.000 s")


@pytest.mark.parametrize("rare", [FLIGHT, FLIGHT[::10]])
@pytest.mark.parametrize("later", [FLIGHT + 0.003, FLIGHT[::10] + 0.003])
def test_a_clock_set_back_is_found_between_tracks_of_any_rates(rare: Array, later: Array) -> None:
    assert clock_set_back(np.concatenate([rare, later])).startswith(f"after {len(rare)} of ")


@pytest.mark.parametrize(
    "t",
    [
        FLIGHT,
        FLIGHT[:2],
        np.concatenate([FLIGHT, FLIGHT + 4.1]),  # set back by 0.89 s
        _with(300, 0.5),  # one that is delivered again
        _with(300, 99.0),  # one with a wrong stamp
        np.concatenate([FLIGHT + 100.0, FLIGHT + 200.0]),
        np.concatenate([FLIGHT[250:], FLIGHT[:250]]),  # the second half first
        _late(3, 200),
        _late(30, 170),
    ],
)
def test_late_and_wrong_stamps_and_a_clock_set_forward_are_no_clock_set_back(t: Array) -> None:
    assert clock_set_back(t) == ""


def _room_bag(file: Path, stamps: Mapping[str, Array]) -> None:
    """Write poses with stamps in the order given, of each topic."""
    with file.open("wb") as stream, Writer(stream) as writer:
        text = "std_msgs/Header header\ngeometry_msgs/Pose pose\n" + POSE + HEADER
        schema = writer.register_msgdef("geometry_msgs/msg/PoseStamped", text)
        for topic, own in stamps.items():
            for row, t in enumerate(own):
                stamp = {"sec": int(t), "nanosec": round(1e9 * (t % 1.0))}
                place = {"position": {"x": t, "y": 0.0, "z": 1.0}, "orientation": {"w": 1.0}}
                message = {"header": {"stamp": stamp, "frame_id": "world"}, "pose": place}
                writer.write_message(topic, schema, message, log_time=row, publish_time=row)


def test_references_that_are_set_back_or_not_there_are_not_called_poses(tmp_path: Path) -> None:
    file, mapped = tmp_path / "room.mcap", TopicMap({"cf1": "/cf1"}, references={"cf1": "/goal"})
    for given, said in (
        (np.concatenate([FLIGHT, FLIGHT]), "references of cf1: after 500 of 1000"),
        (np.zeros(9), "all 9 references of cf1 have the stamp 0 s"),
    ):
        _room_bag(file, {"/cf1": FLIGHT, "/goal": given})
        with pytest.raises(BagError, match=said):
            read_mapped_flight(file, mapped)


def test_a_bag_of_two_flights_on_one_time_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "room.mcap"
    _room_bag(file, {"/cf1": np.concatenate([FLIGHT, FLIGHT])})
    with pytest.raises(BagError, match=r"poses of cf1: after 500 of 1000, .* set back.* split the bag there"):
        read_mapped_flight(file, TopicMap({"cf1": "/cf1"}))
    flight = read_mapped_flight(file, TopicMap({"cf1": "/cf1"}, stamps="receive"))
    assert len(flight.t) == 1000
