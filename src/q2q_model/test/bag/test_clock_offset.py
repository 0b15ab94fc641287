"""Of topics of other software it is said that two clocks stamp them, by when they were received."""

import warnings
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from foreign_bags import POSE_STAMPED
from mcap_ros2.writer import Writer as ForeignWriter

from q2q_model.bag import BagRepairWarning, TopicMap, read_mapped_flight
from q2q_model.bag.foreign.clock_offset import OFFSET_S, MessageTimes, clock_offset
from q2q_model.bag.foreign.mapped_messages import MappedBag
from q2q_model.signals.values import Array

WALL_S = 1.7e9
T = WALL_S + np.arange(0.0, 30.0, 0.01)
"""Times of capture of 30 s at 100 Hz [s]."""
POSES = MessageTimes(T, T + 0.03)
"""Poses that are received 30 ms after their capture."""
MAPPED = TopicMap({"cf1": "/cf1/pose", "cf2": "/cf2/pose"}, references={"cf1": "/cf1/goal"})


@pytest.mark.parametrize("ahead_s", [-3.5, -0.2, 0.2, 2.5])
def test_an_offset_is_found_with_its_sign_but_for_the_difference_of_latencies(ahead_s: float) -> None:
    references = MessageTimes(T + ahead_s, T + 0.001)
    assert clock_offset(POSES, references) == pytest.approx(ahead_s + 0.029, abs=1e-6)
    assert clock_offset(references, POSES) == pytest.approx(-ahead_s - 0.029, abs=1e-6)


def test_of_a_clock_that_drifts_the_worse_half_counts() -> None:
    drifting = MessageTimes(T + 0.01 * (T - WALL_S), T)
    assert 0.15 < clock_offset(MessageTimes(T, T), drifting) < 0.3  # 0.15 to 0.30 s in the second


def test_in_a_bag_that_was_played_slowly_latencies_count_by_the_time_of_the_stamps() -> None:
    slow = WALL_S + 5.0 * (T - WALL_S)
    poses = MessageTimes(T, slow + 5.0 * 0.03)
    assert clock_offset(poses, MessageTimes(T, slow + 5.0 * 0.001)) == pytest.approx(0.029, abs=1e-3)
    assert clock_offset(poses, MessageTimes(T - 0.5, slow)) == pytest.approx(-0.47, abs=1e-3)


def test_a_few_goals_show_an_offset_and_two_do_not() -> None:
    goals = np.array([2.0, 9.0, 20.0]) + WALL_S
    assert clock_offset(POSES, MessageTimes(goals - 1.0, goals)) == pytest.approx(-0.97, abs=1e-6)
    assert clock_offset(POSES, MessageTimes(goals[:2] - 1.0, goals[:2])) == 0.0


def _in_bursts(period_s: float) -> Array:
    """Return times of receipt of messages that are held up to the end of each period."""
    return np.asarray(WALL_S + np.ceil((T - WALL_S) / period_s + 1e-6) * period_s)


SOUND: Mapping[str, MessageTimes] = {
    "random latencies": MessageTimes(T, T + np.random.default_rng(1).gamma(2.0, 0.02, len(T))),
    "bursts of 0.9 s": MessageTimes(T, _in_bursts(0.9)),
    "latched 10 s before the recorder began": MessageTimes(
        T[[10, 1200, 2400]], T[[10, 1200, 2400]] + [10.0, 0.0, 0.0]
    ),
    "one goal sent again with its old stamp": MessageTimes(
        np.append(np.repeat(T[200], 2000), T[2300:]), np.append(T[200:2200], T[2300:])
    ),
    "held up for a tenth of the flight": MessageTimes(T, np.maximum(T, T[300])),
    "held up for 2 s of 8 s": MessageTimes(T[:800], np.maximum(T[:800], T[200])),
    "all received after the poses": MessageTimes(T, T + 40.0),
}


@pytest.mark.parametrize("sound", SOUND)
def test_delays_of_one_topic_are_no_offset(sound: str) -> None:
    assert abs(clock_offset(POSES, SOUND[sound])) < OFFSET_S


@pytest.mark.parametrize(
    "receipt",
    [
        lambda t: 5.0e9 + 2.0 * (t - WALL_S),  # played back at half the rate
        lambda t: 5.0e9 + 0.05 * (t - WALL_S) ** 2,  # simulated, ever slower
        lambda t: 0.0 * t,  # written anew without times
        lambda t: t,  # and with those of the headers
    ],
)
def test_times_of_receipt_that_both_topics_share_are_no_offset(receipt: Callable[[Array], Array]) -> None:
    assert clock_offset(MessageTimes(T, receipt(T)), MessageTimes(T[5:-5:7], receipt(T[5:-5:7]))) == (
        pytest.approx(0.0, abs=1e-4)  # the chord of a parabola over 10 ms is 1e-6 off, a float at 5e9 s 1e-6
    )


def _room(path: Path, ahead_s: Mapping[str, float]) -> Path:
    """Write 8 s of poses and goals, received 1 ms after they are sent; some clocks are ahead of another."""
    with path.open("wb") as stream, ForeignWriter(stream) as writer:
        schema = writer.register_msgdef("geometry_msgs/msg/PoseStamped", POSE_STAMPED)
        for sent_ns in range(10**18, 10**18 + 8 * 10**9, 4 * 10**7):
            for topic in ("/cf1/pose", "/cf2/pose", "/cf1/goal"):
                sec, nanosec = divmod(sent_ns + round(1e9 * ahead_s.get(topic, 0.0)), 10**9)
                place = {"x": 1e-9 * (sent_ns - 10**18), "y": 0.0, "z": 1.0}
                message = {
                    "header": {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": "world"},
                    "pose": {"position": place, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}},
                }
                writer.write_message(topic, schema, message, sent_ns + 10**6, sent_ns)
    return path


def test_of_references_of_another_clock_it_is_said_how_to_read_them(tmp_path: Path) -> None:
    room = _room(tmp_path / "room.mcap", {"/cf1/goal": -0.2})
    found = "stamps of /cf1/goal are 200 ms behind those of /cf1/pose that were received at the same time"
    with pytest.warns(
        BagRepairWarning, match=f"room.mcap: {found}; if they come from two clocks, add `stamps: rec"
    ):
        read_mapped_flight(room, MAPPED)
    by_receipt = TopicMap(MAPPED.vehicles, references=MAPPED.references, stamps="receive")
    flight = read_mapped_flight(room, by_receipt)
    np.testing.assert_array_equal(flight.ref_pos[:, 0], flight.mocap_pos[:, 0])
    assert MappedBag(room, MAPPED).repairs == ()  # it plays no references


def test_nothing_is_said_of_a_bag_whose_clocks_agree(tmp_path: Path) -> None:
    room = _room(tmp_path / "room.mcap", {"/cf1/goal": -0.04})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read_mapped_flight(room, MAPPED).mocap_pos.shape == (200, 2, 3)


def test_poses_of_two_clocks_are_named_where_they_are_played(tmp_path: Path) -> None:
    room = _room(tmp_path / "room.mcap", {"/cf2/pose": 2.0})
    said = MappedBag(room, TopicMap(MAPPED.vehicles)).repairs
    assert any("/cf2/pose are 2000 ms ahead of those of /cf1/pose" in one for one in said)
