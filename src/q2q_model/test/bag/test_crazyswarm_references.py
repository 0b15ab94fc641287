"""References of a topic map from the setpoints of Crazyswarm2, by its own message definitions."""

from pathlib import Path

import numpy as np
import pytest
from mcap_ros2.writer import Writer as ForeignWriter
from message_definitions import HEADER, POSE

from q2q_model.bag import BagError, TopicMap, read_mapped_flight

VECTOR = """================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
TWIST = """================================================================================
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
"""
DEFINITIONS = {
    "geometry_msgs/msg/PoseStamped": f"std_msgs/Header header\ngeometry_msgs/Pose pose\n{HEADER}{POSE}",
    "crazyflie_interfaces/msg/Position": (
        f"std_msgs/Header header\nfloat32 x\nfloat32 y\nfloat32 z\nfloat32 yaw\n{HEADER}"
    ),
    "crazyflie_interfaces/msg/FullState": (
        "std_msgs/Header header\ngeometry_msgs/Pose pose\ngeometry_msgs/Twist twist\n"
        f"geometry_msgs/Vector3 acc\n{HEADER}{POSE}{TWIST}{VECTOR}"
    ),
    "crazyflie_interfaces/msg/VelocityWorld": (
        f"std_msgs/Header header\ngeometry_msgs/Vector3 vel\nfloat32 yaw_rate\n{HEADER}{VECTOR}"
    ),
}
"""As a recorder writes them, of crazyflie_interfaces 1.0.5 (commit f6154e2 of Crazyswarm2)."""
TOPICS = {
    "/cf1/pose": "geometry_msgs/msg/PoseStamped",
    "/cf2/pose": "geometry_msgs/msg/PoseStamped",
    "/cf1/cmd_position": "crazyflie_interfaces/msg/Position",
    "/cf2/cmd_full_state": "crazyflie_interfaces/msg/FullState",
    "/cf1/cmd_velocity_world": "crazyflie_interfaces/msg/VelocityWorld",
}
VEHICLES = {"cf1": "/cf1/pose", "cf2": "/cf2/pose"}
TICKS = 20


def vector(x: float, y: float, z: float) -> dict[str, float]:
    """Return a Point or Vector3."""
    return {"x": x, "y": y, "z": z}


def room_bag(folder: Path) -> Path:
    """Write a bag with poses and every setpoint; values of a tick differ from each other."""
    file = folder / "room.mcap"
    with file.open("wb") as stream, ForeignWriter(stream) as writer:
        schemas = {kind: writer.register_msgdef(kind, text) for kind, text in DEFINITIONS.items()}
        for tick in range(TICKS):
            turn = {"x": 0.0, "y": 0.0, "z": 0.6, "w": 0.8}
            pose = {"position": vector(0.5 * tick, 2.0, 3.0), "orientation": turn}
            others = {
                "twist": {"linear": vector(7.0, 7.1, 7.2), "angular": vector(8.0, 8.0, 8.0)},
                "acc": vector(9.0, 9.1, 9.2),
            }
            values = vector(0.25 * tick, -1.0, 1.5) | {
                "yaw": 90.0,
                "pose": pose,
                "vel": vector(1.0, 1.0, 1.0),
            }
            header = {"stamp": {"sec": 1, "nanosec": tick * 10_000_000}, "frame_id": "world"}
            message = {"header": header, "yaw_rate": 0.0} | values | others
            for topic, kind in TOPICS.items():
                writer.write_message(topic, schemas[kind], message, log_time=tick, publish_time=tick)
    return file


def test_setpoints_of_crazyswarm2_are_references_with_all_that_they_carry(tmp_path: Path) -> None:
    setpoints = {"cf1": "/cf1/cmd_position", "cf2": "/cf2/cmd_full_state"}
    flight = read_mapped_flight(room_bag(tmp_path), TopicMap(VEHICLES, references=setpoints))
    ticks = np.arange(TICKS)
    assert flight.names == ("cf1", "cf2")
    expected = [[(0.25 * tick, -1.0, 1.5), (0.5 * tick, 2.0, 3.0)] for tick in ticks]
    np.testing.assert_array_equal(flight.ref_pos, expected)
    assert np.isnan(flight.ref_vel[:, 0]).all()  # a Position has neither
    assert np.isnan(flight.ref_acc[:, 0]).all()
    np.testing.assert_array_equal(flight.ref_vel[:, 1], np.tile([7.0, 7.1, 7.2], (TICKS, 1)))
    np.testing.assert_array_equal(flight.ref_acc[:, 1], np.tile([9.0, 9.1, 9.2], (TICKS, 1)))
    np.testing.assert_allclose(flight.t, 1.0 + 0.01 * ticks, atol=1e-9)


def test_a_setpoint_without_a_position_is_refused_with_what_is_read(tmp_path: Path) -> None:
    mapped = TopicMap(VEHICLES, references={"cf1": "/cf1/cmd_velocity_world"})
    with pytest.raises(BagError, match=r"VelocityWorld, which cannot be read here; .*FullState, Position$"):
        read_mapped_flight(room_bag(tmp_path), mapped)


@pytest.mark.parametrize("setpoint", ["/cf1/cmd_position", "/cf2/cmd_full_state"])
def test_a_setpoint_is_no_pose_of_a_vehicle(tmp_path: Path, setpoint: str) -> None:
    with pytest.raises(
        BagError, match=r"which cannot be read here; must be one of .*Odometry, TransformStamped$"
    ):
        read_mapped_flight(room_bag(tmp_path), TopicMap({"cf1": setpoint}))
