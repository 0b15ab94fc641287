"""A recording names topics and types that cannot be recorded, and topics that never came."""

import pytest

from q2q_sim.flight_bag.recorded_topics import (
    check_distinct,
    other_types_note,
    recorded_types,
    silent_topics_note,
)

POSE = "geometry_msgs/msg/PoseStamped"


def test_topics_of_q2q_and_further_ones_are_recorded() -> None:
    assert recorded_types(("mocap",), (f"/vicon/cf1/pose:{POSE}",), by_header=True) == {
        "mocap": "q2q_msgs/msg/MocapFrame",
        "/vicon/cf1/pose": POSE,
    }


def test_topics_of_q2q_are_known_with_a_slash_before_them() -> None:
    assert recorded_types(("/state", "mocap"), (), by_header=True) == {
        "mocap": "q2q_msgs/msg/MocapFrame",
        "/state": "q2q_msgs/msg/SwarmState",
    }
    with pytest.raises(ValueError, match="parameter topics: no /room/state; choose from mocap"):
        recorded_types(("/room/state",), (), by_header=True)


def test_a_message_without_a_header_has_no_stamp_to_record_it_by() -> None:
    words = ("/words:std_msgs/msg/String",)
    assert "/words" in recorded_types((), words, by_header=False)
    with pytest.raises(ValueError, match=r"/words: std_msgs/msg/String has no header: give stamps:=receive"):
        recorded_types((), words, by_header=True)


def test_types_that_do_not_exist_are_refused_before_a_bag_is_made() -> None:
    with pytest.raises(ValueError, match="no definition of message type 'std_msgs/msg/Nope'"):
        recorded_types((), ("/words:std_msgs/msg/Nope",), by_header=False)


def test_a_topic_is_recorded_once() -> None:
    check_distinct({"mocap": "/room/mocap", "/mocap": "/mocap"})
    with pytest.raises(
        ValueError, match="mocap and /room/mocap are both /room/mocap, which would be recorded"
    ):
        check_distinct({"mocap": "/room/mocap", "/room/mocap": "/room/mocap"})
    again = (f"/words:{POSE}", "/words:std_msgs/msg/String")
    for extra, twice in ((again, "/words"), ((f"state:{POSE}",), "state")):
        with pytest.raises(
            ValueError, match=f"parameter extra: {twice} would be recorded twice: leave out one"
        ):
            recorded_types((), extra, by_header=False)
    assert recorded_types(("mocap",), (f"state:{POSE}",), by_header=False)["state"] == POSE


def test_a_topic_that_is_published_with_other_types_only_is_named_with_both() -> None:
    assert other_types_note("/state", POSE, ["std_msgs/msg/String", "std_msgs/msg/String"]) == (
        f"/state is published as std_msgs/msg/String, not as {POSE}: it is not recorded"
    )
    assert not other_types_note("/state", POSE, [])
    assert not other_types_note("/state", POSE, ["std_msgs/msg/String", POSE])


def test_silent_topics_are_reported_if_they_were_asked_for_or_none_came() -> None:
    assert silent_topics_note((), ("/mocap",)) == ""
    assert silent_topics_note(("/mocap",), ("/mocap",)) == ""
    assert silent_topics_note(("/mocap", "/pose"), ("/mocap",)).startswith("no message came on /pose:")
    assert silent_topics_note((), ()).startswith("no message came on any topic:")
