"""What of a bag is played: the chosen topics, from a start within it, and what was latched before that."""

from pathlib import Path

import pytest

from q2q_model.bag import BagReader, BagWriter, OfferedQos
from q2q_sim.bag_topics.played_messages import PlayedMessages, check_start, played_topics

SECONDS = range(0, 4_000_000_000, 1_000_000_000)
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


@pytest.mark.parametrize("start", [0.0, 0.5, 3.0])
def test_a_start_within_the_bag_is_fine(start: float) -> None:
    check_start((5_000_000_000 + stamp for stamp in SECONDS), start)


def test_a_start_after_the_end_and_an_empty_bag_are_refused() -> None:
    with pytest.raises(ValueError, match=r"parameter start = 3\.1 s: the bag lasts 3\.0 s"):
        check_start(SECONDS, 3.1)
    with pytest.raises(ValueError, match="no message to play"):
        check_start((), 0.0)
