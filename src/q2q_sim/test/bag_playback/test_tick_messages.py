"""A tick is played with all messages of its stamp, in whatever order the bag has them."""

from pathlib import Path

from q2q_model.bag import BagReader, BagWriter
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.values import MocapFrame, SwarmSetpoint
from q2q_sim.bag_playback.played_messages import PlayedMessages
from q2q_sim.bag_playback.tick_messages import BagTick, TickMessages

MS = 1_000_000


def bag_of(path: Path, *messages: tuple[str, int, int]) -> TickMessages:
    """Write messages, each with topic, tick and bag time [ms]; return them by the ticks on `mocap`."""
    with BagWriter(path) as writer:
        writer.add_topic("/map", "std_msgs/msg/Empty")
        for topic, tick, at in messages:
            kind = MocapFrame if topic == "/mocap" else SwarmSetpoint
            if topic == "/map":
                writer.write_raw(topic, at * MS, b"\x00\x01\x00\x00\x00")
            else:
                writer.write_signal(topic, at * MS, synthetic_signal(kind, tick / 100.0, ("cf1",)))
    bag = BagReader(path)
    played = PlayedMessages(bag, bag.topics, 0.0)
    played.rewind()
    return TickMessages(played, {"/mocap"})


def tick_of(data: bytes) -> int:
    """Return the tick of a header stamp; -1 without a header."""
    return header_stamp_ns(data) // (10 * MS) if len(data) >= 12 else -1


def played(tick: BagTick) -> list[tuple[str, int, int]]:
    """Return topic, tick and bag time [ms] of the messages of a tick."""
    return [(one.topic, tick_of(one.data), one.stamp_ns // MS) for one in tick.messages]


def test_a_tick_takes_its_early_and_late_messages_and_bag_time_does_not_go_back(tmp_path: Path) -> None:
    ticks = bag_of(
        tmp_path / "bag",
        ("/map", 0, 1),
        ("/mocap", 1, 10),
        ("/reference", 2, 15),  # before its tick
        ("/reference", 1, 16),
        ("/mocap", 2, 20),
        ("/map", 0, 21),
        ("/mocap", 3, 30),
        ("/mocap", 4, 40),
        ("/reference", 3, 45),  # after the next tick
        ("/reference", 4, 46),
    )
    first, *rest = [ticks.take() for _ in range(5)]
    assert played(first) == [("/map", -1, 1), ("/mocap", 1, 10), ("/reference", 1, 16)]
    assert [one.topic for one in first.stamped] == ["/mocap", "/reference"]
    assert [played(one) for one in rest] == [
        [("/reference", 2, 16), ("/mocap", 2, 20), ("/map", -1, 21)],
        [("/mocap", 3, 30), ("/reference", 3, 40)],
        [("/mocap", 4, 40), ("/reference", 4, 46)],
        [],
    ]
    assert ticks.is_over
    assert rest[-1].tick is None


def test_a_frame_that_was_sent_twice_is_one_tick(tmp_path: Path) -> None:
    twice = (("/mocap", 1, 10), ("/mocap", 1, 12), ("/reference", 1, 13), ("/mocap", 2, 20))
    ticks = bag_of(tmp_path / "bag", *twice)
    assert [len(ticks.take().messages) for _ in range(3)] == [3, 1, 0]


def test_messages_of_a_stamp_are_looked_for_two_tenths_of_a_second_ahead(tmp_path: Path) -> None:
    frames = [("/mocap", tick, 10 * tick) for tick in range(1, 26)]
    for late, count in ((209, 2), (211, 1)):
        references = [("/reference", 1, late)]
        ticks = bag_of(tmp_path / str(late), *sorted(frames + references, key=lambda one: one[2]))
        assert len(ticks.take().messages) == count
