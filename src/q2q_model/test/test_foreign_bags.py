"""Tests of the topic map on bags of other software: poses, named poses of both versions, ROS 1, sqlite3."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap_ros2.writer import Writer as ForeignWriter
from message_definitions import HEADER, POSE
from resting_signals import resting_state
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as SqliteWriter
from rosbags.typesys import Stores, get_typestore

from q2q_model.bag import (
    BagError,
    BagReader,
    BagRepairWarning,
    BagWriter,
    MappedBag,
    TopicMap,
    load_topic_map,
    read_flight,
    read_mapped_flight,
)
from q2q_model.bag.foreign.pose_frames import Poses, nearest_rows, pose_frames
from q2q_model.bag.foreign.references import References, with_references
from q2q_model.flights.flight import Flight
from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.values import Array, MocapFrame

NAMED_POSES = (
    """std_msgs/Header header
{extra}NamedPose[] poses
================================================================================
MSG: motion_capture_tracking_interfaces/NamedPose
string name
geometry_msgs/Pose pose
================================================================================
MSG: motion_capture_tracking_interfaces/LatencyInfo
string name
float64 value
"""
    + POSE
    + HEADER
)
POSE_STAMPED = "std_msgs/Header header\ngeometry_msgs/Pose pose\n" + POSE + HEADER
SECOND_VERSION = "uint64 timestamp\nLatencyInfo[] latencies\n"
TICKS = 20
MS = 1_000_000
"""[ns]"""


def _place(tick: int, vehicle: int) -> tuple[Array, Array]:
    return np.array([0.01 * tick, float(vehicle), 1.0 + vehicle]), quat_from_euler(0.0, 0.0, 0.02 * tick)


def _pose(tick: int, vehicle: int) -> dict[str, dict[str, float]]:
    pos, quat = _place(tick, vehicle)
    return {
        "position": dict(zip("xyz", pos.tolist(), strict=True)),
        "orientation": dict(zip("xyzw", quat.tolist(), strict=True)),
    }


def _write_named(file: Path, kind: str = "NamedPoseArray", extra: str = "", numbers=(231, 232)) -> None:  # noqa: ANN001
    """Write poses of vehicles cf<number>; the first is not seen in each fourth message."""
    with file.open("wb") as stream, ForeignWriter(stream) as writer:
        name = f"motion_capture_tracking_interfaces/msg/{kind}"
        schema = writer.register_msgdef(name, NAMED_POSES.format(extra=extra))
        for tick in range(TICKS):
            seen = range(tick % 4 == 3, len(numbers))
            message = {
                "header": {"stamp": {"sec": 1, "nanosec": tick * 10_000_000}, "frame_id": "world"},
                "timestamp": 7,
                "latencies": [{"name": "camera", "value": 0.004}],
                "poses": [{"name": f"cf{numbers[k]}", "pose": _pose(tick, k)} for k in seen],
            }
            writer.write_message("/poses", schema, message, log_time=tick, publish_time=tick)
        alone = writer.register_msgdef("geometry_msgs/msg/PoseStamped", POSE_STAMPED)
        message = {"header": {"stamp": {"sec": 1}, "frame_id": "world"}, "pose": _pose(0, 0)}
        writer.write_message("/cf231/pose", alone, message, log_time=0, publish_time=0)


@pytest.mark.parametrize(("kind", "extra"), [("NamedPoseArray", ""), ("NamedPoseArrayV2", SECOND_VERSION)])
def test_named_poses_of_both_versions_are_read_by_their_own_definition(tmp_path: Path, kind: str, extra: str):
    _write_named(tmp_path / "room.mcap", kind, extra)
    mapped = TopicMap(poses="/poses", rename={"cf231": "cf1"})
    flight = read_mapped_flight(tmp_path / "room.mcap", mapped)
    assert set(flight.names) == {"cf1", "cf232"}
    for tick in range(TICKS):
        assert flight.t[tick] == pytest.approx(1.0 + 0.01 * tick, abs=1e-9)
        for k, name in enumerate(("cf1", "cf232")):
            at = flight.mocap_pos[tick, flight.names.index(name)]
            if k == 0 and tick % 4 == 3:
                assert np.isnan(at).all()
            else:
                assert np.array_equal(at, _place(tick, k)[0])
                assert np.array_equal(flight.mocap_quat[tick, flight.names.index(name)], _place(tick, k)[1])


@pytest.mark.parametrize(
    ("mapped", "message"),
    [
        (TopicMap(poses="/poses", rename={"cf231": "cf232"}), "cf232 has poses from cf231 in /poses and"),
        (
            TopicMap({"cf231": "/cf231/pose"}, "/poses"),
            "cf231 has poses from /cf231/pose and from cf231 in /",
        ),
        (TopicMap(poses="/poses", rename={"cf2": "cf1"}), "rename has cf2, .*; names are cf231, cf232"),
        (
            TopicMap({"cf1": "/cf231/pose"}, rename={"cf2": "cf1"}),
            "rename has cf2, .* the topic map has no poses",
        ),
    ],
)
def test_a_vehicle_with_two_sources_or_a_name_of_nobody_is_refused(
    tmp_path: Path, mapped: TopicMap, message: str
):
    _write_named(tmp_path / "room.mcap")
    with pytest.raises(BagError, match=message):
        read_mapped_flight(tmp_path / "room.mcap", mapped)


@pytest.mark.parametrize(
    ("mapped", "known"),
    [
        (
            TopicMap({"cf231": "/poses"}),
            "NamedPoseArray, .* known are PoseStamped, .*Array is read under poses",
        ),
        (TopicMap(poses="/cf231/pose"), "PoseStamped, which is not read here; known are NamedPoseArray,"),
    ],
)
def test_poses_of_one_vehicle_and_of_all_are_not_taken_for_each_other(
    tmp_path: Path, mapped: TopicMap, known: str
) -> None:
    _write_named(tmp_path / "room.mcap")
    with pytest.raises(BagError, match=known):
        read_mapped_flight(tmp_path / "room.mcap", mapped)


@pytest.mark.parametrize(
    ("numbers", "rename", "message"),
    [
        ((8, 7, 7), {"cf7": "cf1"}, "names are cf8; {} messages of /poses name cf7 twice: left out"),
        ((7, 7, 7), {}, "has no pose of any vehicle; {} messages of /poses name cf7 twice: left out"),
    ],
)
def test_where_poses_are_lacking_the_error_says_which_were_left_out(
    tmp_path: Path, numbers: tuple[int, ...], rename: dict[str, str], message: str
) -> None:
    file = tmp_path / "room.mcap"
    _write_named(file, numbers=numbers)
    with pytest.raises(BagError, match=re.escape(message.format(TICKS))):
        read_mapped_flight(file, TopicMap(poses="/poses", rename=rename))


def test_a_vehicle_is_left_out_of_the_messages_that_name_it_twice(tmp_path: Path) -> None:
    """Only the second vehicle is in each fourth message, under the name that both have in the others."""
    _write_named(tmp_path / "room.mcap", numbers=(7, 7, 8))
    left = TICKS - TICKS // 4
    with pytest.warns(UserWarning, match=f": {left} messages of /poses name cf7 twice: left out"):
        flight = read_mapped_flight(tmp_path / "room.mcap", TopicMap(poses="/poses"))
    assert set(flight.names) == {"cf7", "cf8"}
    for tick in range(TICKS):
        at = flight.mocap_pos[tick]
        assert np.array_equal(at[flight.names.index("cf8")], _place(tick, 2)[0])
        once = _place(tick, 1)[0] if tick % 4 == 3 else (np.nan,) * 3
        np.testing.assert_array_equal(at[flight.names.index("cf7")], once)


def _write_ros(writer, store, convert, offset_ns: int = 2 * MS, step_ns: int = 10 * MS, *, back_ns=0) -> None:  # noqa: ANN001
    """Write PoseStamped of a and Odometry of b, b later by an offset, at 100 Hz; set headers back halfway."""
    types = store.types
    point, turn = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/Quaternion"]
    pose_of = types["geometry_msgs/msg/Pose"]
    kinds = ("geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Odometry")
    connections = [
        writer.add_connection(f"/{name}", kind, typestore=store)
        for name, kind in zip("ab", kinds, strict=True)
    ]
    for tick in range(TICKS):
        for k, connection in enumerate(connections):
            pos, quat = _place(tick, k)
            stamp_ns = tick * step_ns + k * offset_ns
            header_ns = stamp_ns - (back_ns if tick >= TICKS // 2 else 0)
            time = types["builtin_interfaces/msg/Time"](sec=0, nanosec=header_ns)
            head = types["std_msgs/msg/Header"]
            header = (
                head(seq=tick, stamp=time, frame_id="w")
                if "seq" in head.__annotations__
                else head(stamp=time, frame_id="w")
            )
            pose = pose_of(position=point(*pos.tolist()), orientation=turn(*quat.tolist()))
            if k == 0:
                message = types[kinds[0]](header=header, pose=pose)
            else:
                zero = types["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
                cov = np.zeros(36)
                twist = types["geometry_msgs/msg/Twist"](linear=zero, angular=zero)
                message = types[kinds[1]](
                    header=header,
                    child_frame_id="b",
                    pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=cov),
                    twist=types["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=cov),
                )
            writer.write(connection, stamp_ns + 1_000_000_000, convert(message, kinds[k]))


def _check(path: Path) -> None:
    flight = read_mapped_flight(path, TopicMap(vehicles={"cf1": "/a", "cf2": "/b"}))
    assert flight.names == ("cf1", "cf2")
    assert np.allclose(flight.t, 0.01 * np.arange(TICKS), atol=1e-9)
    for tick in range(TICKS):
        for k in (0, 1):
            assert np.array_equal(flight.mocap_pos[tick, k], _place(tick, k)[0])
            assert np.array_equal(flight.mocap_quat[tick, k], _place(tick, k)[1])


def test_poses_per_vehicle_are_read_from_an_sqlite_bag(tmp_path: Path):
    store = get_typestore(Stores.ROS2_HUMBLE)
    with SqliteWriter(tmp_path / "old", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        _write_ros(writer, store, store.serialize_cdr)
    _check(tmp_path / "old")


def test_poses_per_vehicle_are_read_from_a_ros_1_bag(tmp_path: Path):
    store = get_typestore(Stores.ROS1_NOETIC)
    with Ros1Writer(tmp_path / "old.bag") as writer:
        _write_ros(writer, store, store.serialize_ros1)
    _check(tmp_path / "old.bag")


def test_a_mapped_bag_gives_its_poses_as_frames_of_ours(tmp_path: Path):
    store = get_typestore(Stores.ROS2_HUMBLE)
    with SqliteWriter(tmp_path / "old", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        _write_ros(writer, store, store.serialize_cdr)
    bag = MappedBag(tmp_path / "old", TopicMap(vehicles={"cf1": "/a", "cf2": "/b"}))
    assert bag.topics == {"mocap": "q2q_msgs/msg/MocapFrame"}
    messages = list(bag.raw({"mocap"}))
    assert [one.stamp_ns for one in messages] == [tick * 10_000_000 for tick in range(TICKS)]
    for tick, one in enumerate(messages):
        frame = decode(one.data, MocapFrame)
        assert frame.names == ("cf1", "cf2")
        assert header_stamp_ns(one.data) == one.stamp_ns
        assert np.array_equal(frame.pos, [_place(tick, k)[0] for k in (0, 1)])
        assert np.array_equal(frame.quat, [_place(tick, k)[1] for k in (0, 1)])


def test_a_mapped_bag_gives_signals_under_our_names_in_the_order_of_their_stamps(tmp_path: Path):
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


def test_a_pose_of_a_slower_vehicle_is_in_one_frame_only():
    ticks, slow = np.arange(12) / 240.0, np.arange(3) / 50.0 + 0.001
    rows = nearest_rows(ticks, slow, 0.005)
    near = [int(np.argmin(np.abs(ticks - t))) for t in slow]
    assert near == [0, 5, 10]
    assert rows[near].tolist() == [0, 1, 2]
    assert (np.delete(rows, near) == -1).all()
    assert nearest_rows(np.array([0.0, 1.0]), np.array([0.5]), 1.0).tolist() == [0, -1]  # as near to both


def _track(t: Array) -> Poses:
    return Poses(t, np.column_stack([t, t, t]), np.tile([0.0, 0.0, 0.0, 1.0], (len(t), 1)), 0.0)


def test_a_vehicle_keeps_its_poses_while_the_fullest_one_is_not_seen():
    every = np.arange(300) / 100.0
    hidden = (every > 0.995) & (every < 1.295)  # 30 ticks
    tracks = {"a": _track(every[~hidden]), "b": _track(every[50:250] + 0.002), "c": _track(every[50:240])}
    frames, repairs = pose_frames(tracks, 0.005)
    assert repairs == []
    assert len(frames) == 300
    seen = {name: [frame.t for frame in frames if name in frame.names] for name in tracks}
    assert {name: len(stamps) for name, stamps in seen.items()} == {"a": 270, "b": 200, "c": 190}
    assert np.allclose([frame.t for frame in frames if frame.names == ("b", "c")], every[hidden] + 0.002)


def test_poses_between_the_frames_make_no_ticks():
    every = np.arange(300) / 100.0
    drifting = every + np.linspace(0.0, 0.005, 300)  # the last 60 are more than 4 ms from both frames
    frames, repairs = pose_frames({"a": _track(every), "b": _track(drifting[:299])}, 0.004)
    assert len(frames) == 300
    assert repairs == ["59 of 299 poses of b match no tick: dropped"]


def test_poses_of_another_clock_are_refused_and_those_after_the_others_kept(tmp_path: Path):
    store = get_typestore(Stores.ROS2_HUMBLE)
    mapped = TopicMap(vehicles={"cf1": "/a", "cf2": "/b"})
    with SqliteWriter(tmp_path / "far", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        _write_ros(writer, store, store.serialize_cdr, offset_ns=700_000_000)
    with pytest.raises(BagError, match=r"poses of cf2 lie at 0\.700 to 0\.890 s.*clocks differ"):
        read_mapped_flight(tmp_path / "far", mapped)
    with SqliteWriter(tmp_path / "near", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        _write_ros(writer, store, store.serialize_cdr, offset_ns=100_000_000)
    flight = read_mapped_flight(tmp_path / "near", mapped)
    assert np.isnan(flight.mocap_pos[:10, 1]).all()
    assert np.array_equal(flight.mocap_pos[10:, 1], [_place(tick, 1)[0] for tick in range(TICKS)])
    assert np.isnan(flight.mocap_pos[20:, 0]).all()


def _flown(poses: Array, references: Array) -> tuple[Flight, list[str]]:
    """Return a flight with poses at some times and references at others, each where its time says."""
    frames, _ = pose_frames({"cf1": _track(poses)}, 0.005)
    flight = flight_from_signals("made", {"mocap": frames}).flight
    pos, unknown = _track(references).pos, np.full((len(references), 3), np.nan)
    return with_references(flight, {"cf1": References(references, pos, unknown, unknown)})


def test_a_reference_holds_until_the_next_and_a_pause_is_reported():
    ticks = 5.0 + np.arange(900) / 100.0
    flight, remarks = _flown(ticks, np.array([3.0, 7.0, 11.5]))
    assert flight.ref_pos[:, 0, 0].tolist() == [3.0] * 200 + [7.0] * 450 + [11.5] * 250
    assert remarks == ["references of cf1 pause for 4.5 s after t = 7.000 s: held"]


def test_references_that_have_ended_are_not_held_for_ever():
    ticks = 5.0 + np.arange(1000) / 100.0
    flight, remarks = _flown(ticks, 5.0 + np.arange(500) / 100.0)  # a stream: three periods of it
    known = np.isfinite(flight.ref_pos[:, 0]).all(axis=1)
    assert ticks[known][-1] == pytest.approx(9.99 + 0.03, abs=1e-6)
    assert remarks == ["references of cf1 end at t = 9.990 s, 5.0 s before the poses: none after 10.020 s"]
    thrice, remarks = _flown(ticks, np.repeat(5.0 + np.arange(500) / 100.0, 3))  # each stamp three times
    np.testing.assert_array_equal(thrice.ref_pos, flight.ref_pos)
    assert remarks[0].endswith("none after 10.020 s")


@pytest.mark.parametrize("goals", [[5.0], [5.0, 5.01, 5.02], [3.0, 5.9, 8.8], [5.0, 5.01, 8.0, 8.01, 8.02]])
def test_the_last_goal_holds_to_the_end_of_the_poses(goals: list[float]):
    """A vehicle that hovers is sent one, once or several times in a row."""
    ticks = 5.0 + np.arange(1000) / 100.0
    flight, remarks = _flown(ticks, np.array(goals))
    assert np.isfinite(flight.ref_pos).all()
    assert flight.ref_pos[-1, 0, 0] == goals[-1]
    ends = f"references of cf1 end at t = {goals[-1]:.3f} s, {14.99 - goals[-1]:.1f} s before the poses"
    assert remarks == [f"{ends}: the last is held"]


@pytest.mark.parametrize("seconds", [0.4, 1.2])
def test_a_short_stream_that_moves_is_no_goal(seconds: float):
    """It may follow a pause in which a hover is held."""
    ticks = 5.0 + np.arange(2000) / 100.0
    stream = 12.0 + np.arange(round(seconds * 20) + 1) / 20.0
    flight, remarks = _flown(ticks, np.concatenate([[5.0, 5.01], stream]))
    known = np.isfinite(flight.ref_pos[:, 0]).all(axis=1)
    assert ticks[known][-1] == pytest.approx(12.0 + seconds + 0.15, abs=1e-6)
    assert remarks[-1].endswith(f"none after {12.15 + seconds:.3f} s")


def test_references_that_end_shortly_before_the_poses_are_not_told():
    assert _flown(5.0 + np.arange(1000) / 100.0, np.array([3.0, 7.0, 12.5]))[1][1:] == []


@pytest.mark.parametrize("clock", [-5.0, 12.0])
def test_references_of_another_clock_are_refused(clock: float):
    ticks = 5.0 + np.arange(500) / 100.0
    spans = f"lie at {clock:.3f} to {clock + 5.0:.3f} s, not 5.000 to 9.990 s: the clocks differ"
    with pytest.raises(ValueError, match=f"references of cf1 {spans}"):
        _flown(ticks, clock + np.arange(6.0))


def test_a_mapped_flight_with_references_of_another_clock_is_refused(tmp_path: Path):
    store = get_typestore(Stores.ROS2_HUMBLE)
    with SqliteWriter(tmp_path / "far", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        _write_ros(writer, store, store.serialize_cdr, offset_ns=700_000_000)
    with pytest.raises(BagError, match=r"far: references of cf1 lie at 0\.700 to 0\.890 s.*clocks differ"):
        read_mapped_flight(tmp_path / "far", TopicMap(vehicles={"cf1": "/a"}, references={"cf1": "/b"}))


def test_headers_that_are_not_filled_are_named(tmp_path: Path):
    store = get_typestore(Stores.ROS2_HUMBLE)
    with SqliteWriter(tmp_path / "still", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        _write_ros(writer, store, store.serialize_cdr, step_ns=0)
    with pytest.raises(BagError, match=r"all 20 poses of cf1 have the stamp 0 s; .*`stamps: receive`"):
        read_mapped_flight(tmp_path / "still", TopicMap(vehicles={"cf1": "/a"}))


def test_poses_between_the_frames_are_refused_with_the_tolerance_that_admits_them(tmp_path: Path):
    store = get_typestore(Stores.ROS2_HUMBLE)
    with SqliteWriter(tmp_path / "between", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        _write_ros(writer, store, store.serialize_cdr, offset_ns=4_000_000)
    mapped = TopicMap(vehicles={"cf1": "/a", "cf2": "/b"}, tolerance_s=0.003)
    with pytest.raises(BagError, match=r"tolerance_s = 0\.003 s of a frame: .* half the period of 0\.010 s"):
        read_mapped_flight(tmp_path / "between", mapped)
    flight = read_mapped_flight(tmp_path / "between", replace(mapped, tolerance_s=0.005))
    assert np.isfinite(flight.mocap_pos).all()


def test_stamps_that_go_back_are_sorted_and_reported(tmp_path: Path):
    store = get_typestore(Stores.ROS2_HUMBLE)
    with SqliteWriter(tmp_path / "back", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        _write_ros(writer, store, store.serialize_cdr, back_ns=50_000_000)
    mapped = TopicMap(vehicles={"cf1": "/a", "cf2": "/b"})
    with pytest.warns(BagRepairWarning) as warned:
        flight = read_mapped_flight(tmp_path / "back", mapped)
    said = " ".join(str(one.message) for one in warned)
    assert "stamps of poses of cf1 go back by up to 0.040 s: sorted" in said
    assert "stamps of poses of cf2 go back by up to 0.040 s: sorted" in said
    assert (np.diff(flight.t) > 0.0).all()


def test_a_topic_without_poses_or_not_there_is_named(tmp_path: Path):
    store = get_typestore(Stores.ROS2_HUMBLE)
    with SqliteWriter(tmp_path / "bag", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        string = writer.add_connection("/talk", "std_msgs/msg/String", typestore=store)
        writer.write(
            string, 0, store.serialize_cdr(store.types["std_msgs/msg/String"](data="hi"), string.msgtype)
        )
    with pytest.raises(BagError, match="std_msgs/msg/String, which is not read here; known are PoseStamped"):
        read_mapped_flight(tmp_path / "bag", TopicMap(vehicles={"cf1": "/talk"}))
    with pytest.raises(BagError, match="has no topic /cf1; it has /talk"):
        read_mapped_flight(tmp_path / "bag", TopicMap(vehicles={"cf1": "/cf1"}))


def test_a_topic_map_is_read_and_its_mistakes_are_named(tmp_path: Path):
    file = tmp_path / "map.yaml"
    file.write_text("vehicles: {cf1: /a}\nposes: /poses\nrename: {cf231: cf2}\nstamps: receive\n")
    assert load_topic_map(file) == TopicMap({"cf1": "/a"}, "/poses", {"cf231": "cf2"}, {}, stamps="receive")
    for text, lines in (
        ("vehicle: {cf1: /a}", "unknown key 'vehicle'; did you mean vehicles"),
        ("vehicles: [a]", "vehicles = .*: a mapping of names to values is expected"),
        ("stamps: wall\nposes: /p", "stamps = 'wall': one of header, receive is expected"),
        ("tolerance_s: -1\nposes: /p", "allowed is 0 to 1 s"),
        ("rename: {a: b}", "maps nothing"),
        (
            "references: {a: /b}\nsignals: {reference: /r}",
            "references and signals: reference are both mapped",
        ),
        ("vehicles: {a: /a}\nsignals: {mocap: /m}", "vehicles and signals: mocap are both mapped; keep one"),
        ("poses: /p\nsignals: {mocap: /m}", "poses and signals: mocap are both mapped; keep one of them"),
        ("signals: {comand: /c}", "map.yaml: signals: q2q has no topic 'comand'; did you mean command"),
        ("signals: {/mocap: /m}", "q2q has no topic '/mocap'; did you mean mocap"),
        ("signals: {plan: /p}", "no topic 'plan'; known are mocap, truth, .*, command"),
        ("[1, 2]", "expected a mapping"),
        ("{", "is not valid YAML: line 1"),
    ):
        file.write_text(text)
        with pytest.raises(BagError, match=lines):
            load_topic_map(file)


@pytest.mark.parametrize("topic", ["state", "imu", "reference"])
def test_a_signal_of_another_type_than_its_topics_is_refused(tmp_path: Path, topic: str):
    """A frame has the positions and attitudes of a state, and no velocities."""
    frame = MocapFrame(0.0, ("a",), np.ones((1, 3)), np.array([[0.0, 0, 0, 1]]))
    with BagWriter(tmp_path / "room") as bag:
        bag.write_signal("/room/frames", 0, frame)
    kinds = {"state": "SwarmState", "imu": "SwarmImu", "reference": "SwarmSetpoint"}
    message = f"/room/frames holds q2q_msgs/msg/MocapFrame; {topic} under signals needs .*{kinds[topic]}$"
    for read in (read_mapped_flight, MappedBag):
        with pytest.raises(BagError, match=message):
            read(tmp_path / "room", TopicMap(signals={topic: "/room/frames"}))


def test_a_state_is_no_frame_under_any_map(tmp_path: Path):
    one = np.zeros((1, 3))
    with BagWriter(tmp_path / "room") as bag:
        bag.write_signal("/mocap", 0, resting_state(0.0, ("a",), one))
    with pytest.raises(BagError, match="mocap under signals needs q2q_msgs/msg/MocapFrame"):
        read_mapped_flight(tmp_path / "room", TopicMap(signals={"mocap": "/mocap"}))
    with pytest.raises(BagError, match="has no message on mocap"):
        read_flight(tmp_path / "room")
