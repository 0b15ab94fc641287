"""What of a bag is played: the chosen topics, from a start within it, and what was latched before that."""

from pathlib import Path

import pytest

from q2q_model.bag import BagReader, BagWriter, OfferedQos
from q2q_sim.bag_playback.played_messages import PlayedMessages, check_start, played_topics

STRING = "std_msgs/msg/String"


def test_a_rewind_gives_the_last_of_each_latched_topic_before_the_start(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for topic in ("/model", "/map", "/words"):
            writer.add_topic(topic, STRING, OfferedQos(transient_local=topic == "/map"))
        for second, topic in enumerate(("/model", "/words", "/model", "/map", "/model", "/words")):
            writer.write_raw(topic, (5 + second) * 1_000_000_000, f"{topic} {second}".encode())
    bag = BagReader(tmp_path / "bag")
    messages = PlayedMessages(bag, bag.topics, 3.5)
    assert messages.latched == {"/model", "/map"}
    for _ in range(2):  # and again in a loop
        assert [one.data for one in messages.rewind()] == [b"/model 2", b"/map 3"]
        assert messages.begin_ns == 8_500_000_000
        left = []
        while messages.next is not None:
            left.append(messages.next.data)
            messages.advance()
        assert left == [b"/model 4", b"/words 5"]
    assert messages.damage is None


def test_the_chosen_topics_are_played_with_or_without_their_first_slash() -> None:
    recorded = {"/mocap": "a/msg/A", "/room/mocap": "a/msg/A", "plan": "a/msg/B"}
    assert played_topics(recorded, ()) == recorded
    assert played_topics(recorded, ("mocap", "/plan")) == {"/mocap": "a/msg/A", "plan": "a/msg/B"}
    with pytest.raises(ValueError, match="the bag has no state; it has /mocap, /room/mocap, plan"):
        played_topics(recorded, ("state", "mocap"))


def late_frames(bag: Path) -> BagReader:
    """Write a bag of words at 5 s to 8 s, and of frames at 7 s."""
    with BagWriter(bag) as writer:
        writer.add_topic("/words", STRING)
        writer.add_topic("/mocap", STRING)
        for second in (5, 7, 8):
            writer.write_raw("/mocap" if second == 7 else "/words", second * 1_000_000_000, b"")
    return BagReader(bag)


def test_a_start_counts_from_the_first_message_of_the_bag_whatever_is_played(tmp_path: Path) -> None:
    bag = late_frames(tmp_path / "bag")
    for topics, played_ns in (({"/mocap"}, 7_000_000_000), ({"/words"}, 8_000_000_000)):
        messages = PlayedMessages(bag, played_topics(bag.topics, topics), 1.5)
        messages.rewind()
        assert messages.next is not None
        assert (messages.begin_ns, messages.next.stamp_ns) == (6_500_000_000, played_ns)


@pytest.mark.parametrize("start", [0.0, 1.5, 2.0])
def test_a_start_up_to_the_last_message_is_fine(tmp_path: Path, start: float) -> None:
    check_start(late_frames(tmp_path / "bag"), {"/mocap"}, start)


def test_a_start_after_the_last_message_and_an_empty_bag_are_refused(tmp_path: Path) -> None:
    bag = late_frames(tmp_path / "bag")
    for topic, start, last in (("/mocap", 2.1, r"2\.0"), ("/words", 3.1, r"3\.0")):
        refusal = rf"start = {start} s: the last message on {topic} is {last} s after the bag's first"
        with pytest.raises(ValueError, match=refusal):
            check_start(bag, {topic}, start)
    with BagWriter(tmp_path / "empty") as writer:
        writer.add_topic("/words", STRING)
    with BagWriter(tmp_path / "silent") as writer:
        writer.add_topic("/words", STRING)
        writer.add_topic("/mocap", STRING)
        writer.write_raw("/words", 5, b"")
    with pytest.raises(ValueError, match="no message to play: none on /mocap"):
        check_start(BagReader(tmp_path / "silent"), {"/mocap"}, 0.0)
    with pytest.raises(ValueError, match="no message to play"):
        check_start(BagReader(tmp_path / "empty"), {"/words"}, 0.0)
