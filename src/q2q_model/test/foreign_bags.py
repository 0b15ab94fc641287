"""Bags of poses as other software writes them: named poses, poses by vehicle, sqlite and ROS 1."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from mcap_ros2.writer import Writer as ForeignWriter
from message_definitions import HEADER, POSE
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as SqliteWriter
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import Array

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


def place(tick: int, vehicle: int) -> tuple[Array, Array]:
    """Return the position (3,) and attitude (4,) of a vehicle in a message."""
    return np.array([0.01 * tick, float(vehicle), 1.0 + vehicle]), quat_from_euler(0.0, 0.0, 0.02 * tick)


def _pose(tick: int, vehicle: int) -> dict[str, dict[str, float]]:
    pos, quat = place(tick, vehicle)
    return {
        "position": dict(zip("xyz", pos.tolist(), strict=True)),
        "orientation": dict(zip("xyzw", quat.tolist(), strict=True)),
    }


def write_named(
    file: Path, kind: str = "NamedPoseArray", extra: str = "", numbers: Sequence[int] = (231, 232)
) -> None:
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


def _header(store: Typestore, tick: int, stamp_ns: int) -> object:
    """Return a header; those of ROS 1 are numbered."""
    head = store.types["std_msgs/msg/Header"]
    number = {"seq": tick} if "seq" in head.__annotations__ else {}
    time = store.types["builtin_interfaces/msg/Time"](sec=0, nanosec=stamp_ns)
    return head(**number, stamp=time, frame_id="w")


def _odometry(store: Typestore, header: object, pose: object) -> object:
    """Return an Odometry without velocities."""
    types, cov = store.types, np.zeros(36)
    zero = types["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
    twist = types["geometry_msgs/msg/Twist"](linear=zero, angular=zero)
    return types["nav_msgs/msg/Odometry"](
        header=header,
        child_frame_id="b",
        pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=cov),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=cov),
    )


def _write_ros(
    writer: Ros1Writer | SqliteWriter,
    store: Typestore,
    convert: Callable[[object, str], bytes | memoryview],
    offset_ns: int = 2 * MS,
    step_ns: int = 10 * MS,
    *,
    back_ns: int = 0,
) -> None:
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
            pos, quat = place(tick, k)
            stamp_ns = tick * step_ns + k * offset_ns
            header_ns = stamp_ns - (back_ns if tick >= TICKS // 2 else 0)
            header = _header(store, tick, header_ns)
            pose = pose_of(position=point(*pos.tolist()), orientation=turn(*quat.tolist()))
            message = types[kinds[0]](header, pose) if k == 0 else _odometry(store, header, pose)
            writer.write(connection, stamp_ns + 1_000_000_000, convert(message, kinds[k]))


def write_sqlite(path: Path, offset_ns: int = 2 * MS, step_ns: int = 10 * MS, *, back_ns: int = 0) -> None:
    """Write PoseStamped of /a and Odometry of /b as a recorder of ROS 2 Humble does."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    with SqliteWriter(path, version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        _write_ros(writer, store, store.serialize_cdr, offset_ns, step_ns, back_ns=back_ns)


def write_ros_1(path: Path) -> None:
    """Write PoseStamped of /a and Odometry of /b as a recorder of ROS 1 does."""
    store = get_typestore(Stores.ROS1_NOETIC)
    with Ros1Writer(path) as writer:
        _write_ros(writer, store, store.serialize_ros1)
