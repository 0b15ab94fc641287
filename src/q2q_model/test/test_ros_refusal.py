"""Tests of why ROS did not start."""

from q2q_model.node.ros_refusal import refusal_of_ros


def test_what_ros_refuses_is_reported_without_places_in_its_source() -> None:
    error = RuntimeError(
        "failed to initialize rcl: Couldn't parse parameter override rule: '-p uris:=[radio://0]'. "
        "Error: Error parsing an event, at /project/src/parse.c:935, at /project/src/rcl/arguments.c:352"
    )
    assert refusal_of_ros(error) == (
        "Couldn't parse parameter override rule: '-p uris:=[radio://0]'. Error: Error parsing an event; "
        "text in a list is quoted: -p \"uris:=['radio://0/80/2M/E7E7E7E701']\""
    )


def test_arguments_that_ros_does_not_know_are_named() -> None:
    message = refusal_of_ros(RuntimeError("['--bad']"))
    assert (
        message
        == "ROS does not know the arguments ['--bad']: allowed is --ros-args -p name:=value, and its like"
    )
