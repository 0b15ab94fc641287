"""Playback tick by tick: which messages are ticks, what answers them, and until when a tick waits."""

import pytest

from q2q_model.bag import RawMessage
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import MocapFrame
from q2q_sim.bag_playback.awaited_tick import AwaitedTick, check_awaited, played_tick_topics
from q2q_sim.bag_playback.tick_messages import BagTick


def message(topic: str, stamp_ns: int) -> RawMessage:
    frame = encode(synthetic_signal(MocapFrame, stamp_ns * 1e-9, ("cf1",)), stamp_ns)
    return RawMessage(topic, stamp_ns, frame, "q2q_msgs/msg/MocapFrame")


def test_a_tick_waits_for_an_answer_of_its_stamp_and_is_played_again_every_two_seconds() -> None:
    ticks = AwaitedTick()
    ticks.begin(10.0, BagTick(None, (message("/state", 5),)))
    assert not ticks.is_answered_by(message("/mocap", 5).data)  # nothing waits
    assert ticks.unanswered(20.0) == ()
    tick, again = message("/mocap", 7), (message("/mocap", 7), message("/reference", 7))
    ticks.begin(10.0, BagTick(tick, (message("/state", 5), *again), again))
    repeated = [ticks.unanswered(now) for now in (11.9, 12.0, 13.9, 14.0)]
    assert repeated == [(), again, (), again]
    assert not ticks.is_answered_by(message("/mocap", 5).data)
    assert ticks.is_answered_by(message("/command", 7).data)
    with pytest.raises(ValueError, match="message has 0 bytes"):
        ticks.is_answered_by(b"")


def test_answers_are_topics_of_ticks_that_are_played() -> None:
    check_awaited("", ["state"])
    check_awaited("/interference", ["/mocap", "state"])
    with pytest.raises(
        ValueError, match=r"wait_for = 'interfrence': no such topic; did you mean interference\?"
    ):
        check_awaited("interfrence", ["mocap"])
    with pytest.raises(ValueError, match=r"would answer itself; play only .* topics:=\[mocap\]"):
        check_awaited("/interference", ["mocap", "interference"])
    with pytest.raises(ValueError, match="messages on mocap, which is not played"):
        check_awaited("interference", ["state"])


def test_ticks_are_those_of_the_namespace_of_the_answer() -> None:
    rooms = ["/a/mocap", "/b/mocap", "/a/state"]
    assert played_tick_topics(rooms, "a/interference") == {"/a/mocap"}
    assert played_tick_topics(rooms, "/b/interference") == {"/b/mocap"}
    assert played_tick_topics(["mocap", "/a/mocap"], "/interference") == {"mocap"}
    for elsewhere in ("", "interference", "c/interference"):
        assert played_tick_topics(rooms, elsewhere) == {"/a/mocap", "/b/mocap"}


def test_answers_and_ticks_may_be_in_a_namespace() -> None:
    check_awaited("room/interference", ["/room/mocap"])
    check_awaited("/interference", ["/room/mocap", "/room/interference"])  # another topic than the bag's
    with pytest.raises(ValueError, match="would answer itself"):
        check_awaited("/room/interference", ["/room/mocap", "/room/interference"])
