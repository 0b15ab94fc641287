"""Tests of why ROS did not start."""

from q2q_model.node.ros_refusal import refusal_of_ros


def test_what_ros_refuses_is_reported_without_places_in_its_source() -> None:
    error = RuntimeError(
        "failed to initialize rcl: Couldn't parse parameter override rule: '-p uris:=[radio://0]'. "
        "Error: Error parsing an event, at /project/src/parse.c:935, at /project/src/rcl/arguments.c:352"
    )
    assert refusal_of_ros(error) == (
        "Couldn't parse parameter override rule: '-p uris:=[radio://0]'. Error: Error parsing an event; "
        "quote texts in a list: -p \"uris:=['radio://0/80/2M/E7E7E7E701']\""
    )


def test_a_parameter_without_a_value_is_answered_with_how_an_empty_one_is_given() -> None:
    error = RuntimeError("Couldn't parse parameter override rule: '-p model:='. Error: error not set")
    assert refusal_of_ros(error) == (
        "parameter model has no value: for an empty text give -p \"model:=''\", for an empty list "
        "-p model:=[]"
    )


def test_lists_are_explained_only_where_one_is_given() -> None:
    for message in (
        "Couldn't parse trailing -p flag. No parameter override rule found.",
        "Couldn't parse parameter override rule: '-p =3'. Error: Expecting token or wildcard",
    ):
        assert refusal_of_ros(RuntimeError(message)) == message


def test_arguments_that_ros_does_not_know_are_named() -> None:
    message = refusal_of_ros(RuntimeError("['--bad']"))
    assert (
        message == "ROS does not know the arguments ['--bad']; give arguments like --ros-args -p name:=value"
    )
