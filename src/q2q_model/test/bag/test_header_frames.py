"""Positions of several frames, as the headers of other software name them, are not joined."""

from collections.abc import Callable
from pathlib import Path

import foreign_bags
import pytest
from foreign_bags import POSE_STAMPED, TICKS, write_ros_1
from mcap_ros2.writer import Writer
from rosbags.typesys.store import Typestore

from q2q_model.bag import BagError, TopicMap, read_mapped_flight
from q2q_model.bag.foreign.mapped_messages import MappedBag

MAP = TopicMap(vehicles={"cf1": "/a", "cf2": "/b"}, references={"cf1": "/r"})


def pose_bag(folder: Path, frame_of: Callable[[str, int], str]) -> Path:
    """Return a bag of PoseStamped under /a, /b and /r, with the frame of each topic and tick."""
    file = folder / "poses.mcap"
    with file.open("wb") as stream, Writer(stream) as writer:
        schema = writer.register_msgdef("geometry_msgs/msg/PoseStamped", POSE_STAMPED)
        for tick in range(TICKS):
            for k, topic in enumerate(("/a", "/b", "/r")):
                header = {
                    "stamp": {"sec": 1, "nanosec": tick * 10_000_000},
                    "frame_id": frame_of(topic, tick),
                }
                place = {"position": {"x": 0.01 * tick, "y": float(k), "z": 1.0}, "orientation": {"w": 1.0}}
                message = {"header": header, "pose": place}
                writer.write_message(topic, schema, message, log_time=tick, publish_time=tick)
    return file


def test_vehicles_of_two_frames_are_refused_with_topics_and_frames(tmp_path: Path) -> None:
    bag = pose_bag(tmp_path, lambda topic, _: "camera_link" if topic == "/b" else "world")
    with pytest.raises(BagError, match="2 frames: /a in world, /b in camera_link, /r in world; map topics"):
        read_mapped_flight(bag, MAP)
    with pytest.raises(BagError, match="/b in camera_link; map topics"):
        MappedBag(bag, MAP)
    alone = TopicMap(vehicles={"cf1": "/a"}, references={"cf1": "/r"})
    assert read_mapped_flight(bag, alone).names == ("cf1",)


def test_a_reference_of_another_frame_or_one_that_changes_in_flight_is_refused(tmp_path: Path) -> None:
    bag = pose_bag(tmp_path, lambda topic, _: "base_link" if topic == "/r" else "world")
    with pytest.raises(BagError, match="/r in base_link"):
        read_mapped_flight(bag, MAP)
    assert len(MappedBag(bag, MAP).topics) == 1  # plays no references
    bag = pose_bag(tmp_path, lambda _, tick: "world" if tick < TICKS // 2 else "odom")
    with pytest.raises(BagError, match="/a in world and odom, /b in world and odom"):
        read_mapped_flight(bag, MAP)


@pytest.mark.parametrize("other", ["", "/world"])
def test_an_empty_frame_and_one_with_a_slash_are_no_other_frame(tmp_path: Path, other: str) -> None:
    bag = pose_bag(tmp_path, lambda topic, _: other if topic == "/b" else "world")
    assert read_mapped_flight(bag, MAP).names == ("cf1", "cf2")


@pytest.mark.parametrize("in_bag", ["", "/"])
@pytest.mark.parametrize("in_map", ["", "/"])
def test_frames_that_the_map_lists_are_one(tmp_path: Path, in_bag: str, in_map: str) -> None:
    bag = pose_bag(tmp_path, lambda topic, _: in_bag + ("mocap" if topic == "/b" else "world"))
    frames = f"{in_map}world", f"{in_map}mocap"
    listed = TopicMap(MAP.vehicles, references=MAP.references, frames=frames)
    assert read_mapped_flight(bag, listed).names == ("cf1", "cf2")
    bag = pose_bag(tmp_path, lambda topic, _: {"/a": "world", "/b": "mocap", "/r": "base_link"}[topic])
    with pytest.raises(BagError, match="in 3 frames"):
        read_mapped_flight(bag, listed)


def test_frames_of_ros_1_are_read_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mapped, plain = TopicMap(vehicles={"cf1": "/a", "cf2": "/b"}), foreign_bags._header

    def header(store: Typestore, tick: int, stamp_ns: int) -> object:
        made = plain(store, tick, stamp_ns)
        vars(made)["frame_id"] = "odom" if tick == TICKS - 1 else "world"
        return made

    write_ros_1(tmp_path / "one.bag")
    assert read_mapped_flight(tmp_path / "one.bag", mapped).names == ("cf1", "cf2")
    monkeypatch.setattr(foreign_bags, "_header", header)
    write_ros_1(tmp_path / "two.bag")
    with pytest.raises(BagError, match="/a in world and odom, /b in world and odom"):
        read_mapped_flight(tmp_path / "two.bag", mapped)
