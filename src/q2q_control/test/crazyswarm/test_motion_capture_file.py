from pathlib import Path

import pytest
import yaml

from q2q_control.crazyswarm.configured_vehicles import poses_version
from q2q_control.crazyswarm.crazyswarm_params import CrazyswarmParams
from q2q_control.crazyswarm.motion_capture_file import (
    check_tracking,
    motion_capture_from_document,
)

MOCAP = """
/motion_capture_tracking:
  ros__parameters:
    type: "optitrack"
    hostname: "192.168.1.10"
    topics:
      frame_id: "mocap"
      poses:
        qos: {mode: "sensor", deadline: 100.0}
      tf: {child_frame_id: "{}_mocap"}
    marker_configurations:
      default_single_marker: {offset: [0.0, -0.01, -0.04], points: {p0: [0.018, 0.014, 0.056]}}
      mocap_deck: {offset: [0.0, 0.0, -0.01], points: {p0: [0.03, 0.0, 0.0]}}
    dynamics_configurations:
      default: {max_velocity: [2, 2, 3], max_roll: 1.4}
"""
"""In the form that Crazyswarm2 1.0.5 ships."""


def crazyflies(marker: str, *, enabled: bool = True, tracking: str = "librigidbodytracker") -> object:
    capture = {"tracking": tracking, "marker": marker, "dynamics": "default"}
    return {
        "fileversion": 3,
        "robots": {"cf1": {"enabled": enabled, "uri": "radio://0/80/2M/E7E7E7E701", "type": "cf21"}},
        "robot_types": {"cf21": {"motion_capture": capture, "big_quad": False}},
        "all": {"reference_frame": "world"},
    }


def test_what_does_not_concern_q2q_is_ignored_and_the_version_is_1_where_none_is_given():
    settings = motion_capture_from_document(yaml.safe_load(MOCAP))
    assert settings.topics.poses.version == 1
    assert [*settings.marker_configurations] == ["default_single_marker", "mocap_deck"]


def test_the_version_of_the_poses_is_read():
    document = yaml.safe_load(MOCAP)
    document["/motion_capture_tracking"]["ros__parameters"]["topics"]["poses"]["version"] = 2
    assert motion_capture_from_document(document).topics.poses.version == 2


def test_a_version_that_does_not_exist_is_refused_by_key():
    document = {"/mocap": {"ros__parameters": {"topics": {"poses": {"version": 3}}}}}
    with pytest.raises(ValueError, match=r"version.*1 .*or 2"):
        motion_capture_from_document(document)


def test_a_file_of_several_nodes_is_refused():
    with pytest.raises(ValueError, match="has 2 nodes"):
        motion_capture_from_document({"/a": {"ros__parameters": {}}, "/b": {"ros__parameters": {}}})


def test_markers_that_exist_pass_by_robot_and_by_type():
    settings = motion_capture_from_document(yaml.safe_load(MOCAP))
    check_tracking(settings, crazyflies("mocap_deck"))
    own = {"tracking": "librigidbodytracker", "marker": "default_single_marker", "dynamics": "default"}
    robots = {"robots": {"cf1": {"enabled": True, "motion_capture": own}}}
    check_tracking(settings, robots)


def test_a_marker_that_is_nowhere_is_refused_with_vehicle_and_known_names():
    settings = motion_capture_from_document(yaml.safe_load(MOCAP))
    with pytest.raises(ValueError, match=r"cf1: marker = 'big_frame'.*default_single_marker, mocap_deck"):
        check_tracking(settings, crazyflies("big_frame"))


@pytest.mark.parametrize(("enabled", "tracking"), [(False, "librigidbodytracker"), (True, "vendor")])
def test_vehicles_that_the_tracker_does_not_track_need_no_marker(enabled: bool, tracking: str):
    settings = motion_capture_from_document(yaml.safe_load(MOCAP))
    check_tracking(settings, crazyflies("big_frame", enabled=enabled, tracking=tracking))


def test_the_node_takes_the_version_of_the_file_and_checks_its_markers(tmp_path: Path):
    mocap, fleet = tmp_path / "motion_capture.yaml", tmp_path / "crazyflies.yaml"
    mocap.write_text(MOCAP.replace("poses:\n", "poses:\n        version: 2\n"))
    fleet.write_text(yaml.safe_dump(crazyflies("mocap_deck")))
    params = CrazyswarmParams(crazyflies=str(fleet), motion_capture=str(mocap))
    assert poses_version(params) == 2
    fleet.write_text(yaml.safe_dump(crazyflies("big_frame")))
    with pytest.raises(ValueError, match="big_frame"):
        poses_version(params)


def test_without_the_file_the_parameter_holds():
    assert poses_version(CrazyswarmParams(vehicles=("cf1",), poses_version=2)) == 2
