"""Messages of a mapped bag: frames made of poses, and signals under other names."""

from pathlib import Path

import numpy as np
import pytest
from foreign_bags import TICKS, place, write_sqlite
from resting_signals import resting_state

from q2q_model.bag import (
    BagError,
    BagReader,
    BagWriter,
    MappedBag,
    TopicMap,
    read_flight,
    read_mapped_flight,
)
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.values import MocapFrame


def test_a_mapped_bag_gives_its_poses_as_frames_of_ours(tmp_path: Path) -> None:
    write_sqlite(tmp_path / "old")
    bag = MappedBag(tmp_path / "old", TopicMap(vehicles={"cf1": "/a", "cf2": "/b"}))
    assert bag.topics == {"mocap": "q2q_msgs/msg/MocapFrame"}
    messages = list(bag.raw({"mocap"}))
    assert [one.stamp_ns for one in messages] == [tick * 10_000_000 for tick in range(TICKS)]
    for tick, one in enumerate(messages):
        frame = decode(one.data, MocapFrame)
        assert frame.names == ("cf1", "cf2")
        assert header_stamp_ns(one.data) == one.stamp_ns
        assert np.array_equal(frame.pos, [place(tick, k)[0] for k in (0, 1)])
        assert np.array_equal(frame.quat, [place(tick, k)[1] for k in (0, 1)])


def test_a_mapped_bag_gives_signals_under_our_names_in_the_order_of_their_stamps(tmp_path: Path) -> None:
    frames = [MocapFrame(0.25 * k, ("a",), np.full((1, 3), k), np.array([[0.0, 0, 0, 1]])) for k in range(4)]
    with BagWriter(tmp_path / "room") as bag:
        for k in (1, 0, 3, 2):  # as they came
            bag.write_signal("/room/frames", 10**9 + k, frames[k])
            bag.write_signal("/other", 10**9 + k, frames[k])
    mapped = MappedBag(tmp_path / "room", TopicMap(signals={"mocap": "/room/frames"}))
    written = {header_stamp_ns(one.data): one.data for one in BagReader(tmp_path / "room").raw()}
    assert [(one.topic, one.stamp_ns, one.data) for one in mapped.raw(mapped.topics)] == [
        ("mocap", stamp_ns, data) for stamp_ns, data in sorted(written.items())
    ]
    assert list(mapped.raw(set())) == []


@pytest.mark.parametrize("topic", ["state", "imu", "reference"])
def test_a_signal_of_another_type_than_its_topics_is_refused(tmp_path: Path, topic: str) -> None:
    """A frame has the positions and attitudes of a state, and no velocities."""
    frame = MocapFrame(0.0, ("a",), np.ones((1, 3)), np.array([[0.0, 0, 0, 1]]))
    with BagWriter(tmp_path / "room") as bag:
        bag.write_signal("/room/frames", 0, frame)
    kinds = {"state": "SwarmState", "imu": "SwarmImu", "reference": "SwarmSetpoint"}
    message = f"/room/frames holds q2q_msgs/msg/MocapFrame; {topic} under signals needs .*{kinds[topic]}$"
    for read in (read_mapped_flight, MappedBag):
        with pytest.raises(BagError, match=message):
            read(tmp_path / "room", TopicMap(signals={topic: "/room/frames"}))


def test_a_state_is_no_frame_under_any_map(tmp_path: Path) -> None:
    one = np.zeros((1, 3))
    with BagWriter(tmp_path / "room") as bag:
        bag.write_signal("/mocap", 0, resting_state(0.0, ("a",), one))
    with pytest.raises(BagError, match="mocap under signals needs q2q_msgs/msg/MocapFrame"):
        read_mapped_flight(tmp_path / "room", TopicMap(signals={"mocap": "/mocap"}))
    with pytest.raises(BagError, match="has no message on mocap"):
        read_flight(tmp_path / "room")
