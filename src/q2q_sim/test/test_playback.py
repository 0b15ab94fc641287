"""What of a bag can be played: a start within it, and answers that ticks can wait for."""

import pytest

from q2q_sim.bag_topics.playback import Playback, check_answer, check_start, played_tick_topics

SECONDS = range(0, 4_000_000_000, 1_000_000_000)


def test_a_pause_delays_what_is_due_after_it_and_a_round_begins_with_the_end_of_the_last() -> None:
    playback = Playback(first_ns=2_000_000_000, began=10.0, rate=2.0)
    assert playback.due(6_000_000_000) == 12.0
    assert playback.after_pause(5.0).due(6_000_000_000) == 17.0
    assert playback.next_round(6_000_000_000, 12.0).due(6_000_000_000) == 14.0
    assert playback.next_round(2_000_000_000, 12.0).due(2_000_000_000) == 13.0  # a bag of one moment


@pytest.mark.parametrize("start", [0.0, 0.5, 3.0])
def test_a_start_within_the_bag_is_fine(start: float) -> None:
    check_start((5_000_000_000 + stamp for stamp in SECONDS), start)


def test_a_start_after_the_end_and_an_empty_bag_are_refused() -> None:
    with pytest.raises(ValueError, match=r"parameter start = 3\.1 s: the bag lasts 3\.0 s"):
        check_start(SECONDS, 3.1)
    with pytest.raises(ValueError, match="no message to play"):
        check_start((), 0.0)


def test_answers_are_topics_of_ticks_that_are_played() -> None:
    check_answer("", ["state"])
    check_answer("/interference", ["/mocap", "state"])
    with pytest.raises(
        ValueError, match=r"answer = 'interfrence': no such topic; did you mean interference\?"
    ):
        check_answer("interfrence", ["mocap"])
    with pytest.raises(ValueError, match=r"would answer itself; play only .* topics:=\[mocap\]"):
        check_answer("/interference", ["mocap", "interference"])
    with pytest.raises(ValueError, match="messages on mocap, which is not played"):
        check_answer("interference", ["state"])


def test_ticks_are_those_of_the_namespace_of_the_answer() -> None:
    rooms = ["/a/mocap", "/b/mocap", "/a/state"]
    assert played_tick_topics(rooms, "a/interference") == {"/a/mocap"}
    assert played_tick_topics(rooms, "/b/interference") == {"/b/mocap"}
    assert played_tick_topics(["mocap", "/a/mocap"], "/interference") == {"mocap"}
    for elsewhere in ("", "interference", "c/interference"):
        assert played_tick_topics(rooms, elsewhere) == {"/a/mocap", "/b/mocap"}


def test_answers_and_ticks_may_be_in_a_namespace() -> None:
    check_answer("room/interference", ["/room/mocap"])
    check_answer("/interference", ["/room/mocap", "/room/interference"])  # another topic than the bag's
    with pytest.raises(ValueError, match="would answer itself"):
        check_answer("/room/interference", ["/room/mocap", "/room/interference"])
