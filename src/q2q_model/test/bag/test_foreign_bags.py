"""Poses of each vehicle in bags of other software: read, or refused with what to change in the map."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from foreign_bags import TICKS, place, write_ros_1, write_sqlite
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as SqliteWriter
from rosbags.typesys import Stores, get_typestore

from q2q_model.bag import (
    BagError,
    BagRepairWarning,
    TopicMap,
    read_mapped_flight,
)


@pytest.mark.parametrize(("write", "name"), [(write_sqlite, "old"), (write_ros_1, "old.bag")])
def test_poses_per_vehicle_are_read_from_bags_of_sqlite_and_of_ros_1(
    tmp_path: Path, write: Callable[[Path], None], name: str
) -> None:
    write(tmp_path / name)
    flight = read_mapped_flight(tmp_path / name, TopicMap(vehicles={"cf1": "/a", "cf2": "/b"}))
    assert flight.names == ("cf1", "cf2")
    assert np.allclose(flight.t, 0.01 * np.arange(TICKS), atol=1e-9)
    for tick in range(TICKS):
        for k in (0, 1):
            assert np.array_equal(flight.mocap_pos[tick, k], place(tick, k)[0])
            assert np.array_equal(flight.mocap_quat[tick, k], place(tick, k)[1])


def test_poses_of_another_clock_are_refused_and_those_after_the_others_kept(tmp_path: Path) -> None:
    mapped = TopicMap(vehicles={"cf1": "/a", "cf2": "/b"})
    write_sqlite(tmp_path / "far", offset_ns=700_000_000)
    with pytest.raises(BagError, match=r"poses of cf2 lie at 0\.700 to 0\.890 s.*clocks differ"):
        read_mapped_flight(tmp_path / "far", mapped)
    write_sqlite(tmp_path / "near", offset_ns=100_000_000)
    flight = read_mapped_flight(tmp_path / "near", mapped)
    assert np.isnan(flight.mocap_pos[:10, 1]).all()
    assert np.array_equal(flight.mocap_pos[10:, 1], [place(tick, 1)[0] for tick in range(TICKS)])
    assert np.isnan(flight.mocap_pos[20:, 0]).all()


def test_headers_that_are_not_filled_are_named(tmp_path: Path) -> None:
    write_sqlite(tmp_path / "still", step_ns=0)
    with pytest.raises(BagError, match=r"all 20 poses of cf1 have the stamp 0 s; .*`stamps: receive`"):
        read_mapped_flight(tmp_path / "still", TopicMap(vehicles={"cf1": "/a"}))


def test_poses_between_the_frames_are_refused_with_the_tolerance_that_admits_them(tmp_path: Path) -> None:
    write_sqlite(tmp_path / "between", offset_ns=4_000_000)
    mapped = TopicMap(vehicles={"cf1": "/a", "cf2": "/b"}, tolerance_s=0.003)
    with pytest.raises(BagError, match=r"tolerance_s = 0\.003 s of a frame: .* half the period of 0\.010 s"):
        read_mapped_flight(tmp_path / "between", mapped)
    flight = read_mapped_flight(tmp_path / "between", replace(mapped, tolerance_s=0.005))
    assert np.isfinite(flight.mocap_pos).all()


def test_stamps_that_go_back_are_sorted_and_reported(tmp_path: Path) -> None:
    write_sqlite(tmp_path / "back", back_ns=50_000_000)
    mapped = TopicMap(vehicles={"cf1": "/a", "cf2": "/b"})
    with pytest.warns(BagRepairWarning) as warned:
        flight = read_mapped_flight(tmp_path / "back", mapped)
    said = " ".join(str(one.message) for one in warned)
    assert "stamps of poses of cf1 go back by up to 0.040 s: sorted" in said
    assert "stamps of poses of cf2 go back by up to 0.040 s: sorted" in said
    assert (np.diff(flight.t) > 0.0).all()


def test_a_topic_without_poses_or_not_there_is_named(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    with SqliteWriter(tmp_path / "bag", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        string = writer.add_connection("/talk", "std_msgs/msg/String", typestore=store)
        writer.write(
            string, 0, store.serialize_cdr(store.types["std_msgs/msg/String"](data="hi"), string.msgtype)
        )
    with pytest.raises(
        BagError, match="std_msgs/msg/String, which cannot be read here; must be one of PoseStamped"
    ):
        read_mapped_flight(tmp_path / "bag", TopicMap(vehicles={"cf1": "/talk"}))
    with pytest.raises(BagError, match="has no topic /cf1; it has /talk"):
        read_mapped_flight(tmp_path / "bag", TopicMap(vehicles={"cf1": "/cf1"}))
