"""The player says what of a bag it cannot play, and plays the rest."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rosbags.rosbag2 import StoragePlugin, Writer
from std_srvs.srv import Trigger

from q2q_model.bag import BagError, BagWriter
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.values import MocapFrame, SwarmSetpoint, SwarmState
from q2q_sim.processes.domain import own_domain
from q2q_sim.ros.bag_play_node import Player

TICKS = 200
"""Two chunks of a second each."""


def recorded(bag: Path, topic: str = "/mocap") -> Path:
    """Write a bag of frames; return its file."""
    with BagWriter(bag) as writer:
        for tick in range(TICKS):
            frame = synthetic_signal(MocapFrame, tick / 100.0, ("cf1",))
            writer.write_signal(topic, tick * 10_000_000, frame)
    return bag / f"{bag.name}_0.mcap"


@dataclass(frozen=True, slots=True)
class Listening:
    """Publisher that notes the topic and tick of each message."""

    topic: str
    writer: Publisher
    sent: list[tuple[str, int]]

    def publish(self, data: bytes) -> None:
        """Note a message and send it."""
        self.sent.append((self.topic, header_stamp_ns(data) // 10**7))
        self.writer.publish(data)

    def wait_for_all_acked(self, timeout: Duration) -> bool:
        """Wait as the publisher does."""
        return bool(self.writer.wait_for_all_acked(timeout))


@contextmanager
def waiting_player(bag: Path, *given: str) -> Iterator[Player]:
    """Yield a player that waits for its start, with these parameters."""
    with own_domain():
        words = [word for one in (f"bag:={bag}", "autostart:=false", *given) for word in ("-p", one)]
        rclpy.init(args=["--ros-args", *words])
        node = Node("bag_play")
        try:
            yield Player(node)
        finally:
            node.destroy_node()
            rclpy.try_shutdown()


def play(player: Player, messages: int = TICKS) -> None:
    """Play so many messages, or to the end."""
    for _ in range(messages):
        if (message := player._messages.next) is not None:
            player._play_next(message)


def played(bag: Path) -> Player:
    """Play a bag to its end, as fast as it is read."""
    with waiting_player(bag) as player:
        player._begin()
        play(player)
        return player


def test_only_the_ticks_of_the_room_that_answers_wait(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "rooms") as writer:
        for tick in range(6):
            for row, room in enumerate("ab"):
                frame = synthetic_signal(MocapFrame, tick / 100.0, (f"cf_{room}",))
                writer.write_signal(f"/{room}/mocap", tick * 10_000_000 + row, frame)
    with waiting_player(tmp_path / "rooms", "wait_for:=b/interference") as player:
        player._begin()
        waited = []
        while player._ticks.awaited is not None:
            waited.append((player._ticks.awaited.topic, player._ticks.awaited.stamp_ns))
            player._on_answer(player._ticks.awaited.data)
    assert waited == [("/b/mocap", tick * 10_000_000 + 1) for tick in range(6)]


def test_a_bag_that_was_cut_off_is_played_and_reported(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = recorded(tmp_path / "bag")
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    (tmp_path / "bag" / "metadata.yaml").unlink()
    played(tmp_path / "bag").close()
    assert "(it was not closed); recovered" in capfd.readouterr().err


def test_a_bag_is_played_up_to_its_damage_which_is_reported(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = recorded(tmp_path / "bag")
    damaged = bytearray(file.read_bytes())
    damaged[len(damaged) // 2] ^= 0xFF
    file.write_bytes(damaged)
    player = played(tmp_path / "bag")
    assert "playback over" in capfd.readouterr().err
    with pytest.raises(BagError, match=r"is damaged after \d+ messages"):
        player.close()


def test_a_type_that_is_not_installed_is_named_with_the_way_out(tmp_path: Path) -> None:
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        kind = "absent_msgs/msg/Level"
        channel = writer.add_connection("/level", kind, msgdef="float64 level\n", rihs01="RIHS01_0")
        writer.write(channel, 1, b"\x00\x01\x00\x00" + bytes(8))
    with pytest.raises(ValueError, match=r"/level holds absent_msgs/msg/Level, which is not .*topics:=\["):
        played(tmp_path / "bag")


@pytest.mark.parametrize("place", ["", "room/"])
def test_in_a_loop_every_tick_waits_for_the_answer_to_the_last(tmp_path: Path, place: str) -> None:
    recorded(tmp_path / "bag", f"/{place}mocap")
    given = f"wait_for:={place}interference", "loop:=true", "start:=1.97"
    with waiting_player(tmp_path / "bag", *given) as player:
        player._begin()
        ticks = []
        for _ in range(7):
            assert player._ticks.awaited is not None
            ticks.append(player._ticks.awaited.stamp_ns // 10_000_000)
            player._on_answer(player._ticks.awaited.data)
    assert ticks == [197, 198, 199, 197, 198, 199, 197]
    assert player._health.ticks == len(ticks) + 1


def test_answers_to_ticks_need_a_tick_after_the_start(tmp_path: Path) -> None:
    recorded(tmp_path / "bag")
    with BagWriter(tmp_path / "longer") as writer:
        for tick, topic in ((0, "/mocap"), (1, "/mocap"), (500, "/state")):
            signal = synthetic_signal(MocapFrame if topic == "/mocap" else SwarmState, tick / 100.0, ("cf1",))
            writer.write_signal(topic, tick * 10_000_000, signal)
    given = tmp_path / "longer", "loop:=true", "start:=2.0"
    with waiting_player(*given) as player:
        player._begin()
    refusal = r"parameter start = 2 s: the last message on /mocap is 0\.0 s after the bag's first"
    with pytest.raises(ValueError, match=refusal), waiting_player(*given, "wait_for:=interference"):
        pass


def test_a_second_start_is_refused_and_the_playback_goes_on(tmp_path: Path) -> None:
    recorded(tmp_path / "bag")
    with waiting_player(tmp_path / "bag") as player:

        def start() -> tuple[bool, str]:
            response = player._on_start(Trigger.Request(), Trigger.Response())
            return response.success, response.message

        assert start() == (True, "")
        play(player, 1)
        assert start() == (False, "already playing")
        assert player._messages.next is not None
        assert player._messages.next.stamp_ns == 10_000_000
        play(player)
        assert start() == (False, "the playback is over: restart the node for another one")


def test_an_answer_without_a_header_is_refused_and_the_next_one_goes_on(tmp_path: Path) -> None:
    recorded(tmp_path / "bag")
    with waiting_player(tmp_path / "bag", "wait_for:=interference") as player:
        player._begin()
        tick = player._ticks.awaited
        player._on_answer(b"")
        assert player._health.last_refusal == "interference: message has 0 bytes; a header needs at least 12"
        assert player._ticks.awaited is tick is not None
        player._on_answer(tick.data)
        assert player._ticks.awaited is not tick


def test_an_answer_may_need_every_message_of_its_tick(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for tick in range(3):
            writer.write_signal("/mocap", tick * 10**7, synthetic_signal(MocapFrame, tick / 100, ("cf1",)))
            setpoint = synthetic_signal(SwarmSetpoint, tick / 100, ("cf1",))
            if tick < 2:  # the bag was cut off before that of the last tick
                writer.write_signal("/reference", tick * 10**7, setpoint)
    sent: list[tuple[str, int]] = []
    with waiting_player(tmp_path / "bag", "wait_for:=command") as player:
        now = [0.0]
        monkeypatch.setattr("q2q_sim.ros.bag_play_node.monotonic", lambda: now[0])
        for topic, writer in player._writers.items():
            monkeypatch.setitem(player._writers, topic, Listening(topic, writer, sent))
        player._begin()
        first = [("/mocap", 0), ("/reference", 0)]
        assert sent == first
        now[0] = 2.0
        player._on_stall()
        assert sent == first * 2
        for _ in range(2):
            assert player._ticks.awaited is not None
            player._on_answer(player._ticks.awaited.data)
        assert sent[4:] == [("/mocap", 1), ("/reference", 1), ("/mocap", 2)]
        assert "playback over" not in capfd.readouterr().err
        now[0] = 4.0
        player._on_stall()
    assert "playback over" in capfd.readouterr().err


def played_at(player: Player, monkeypatch: pytest.MonkeyPatch, *moments: float) -> list[int]:
    """Begin at 0 s; return how many ticks are played in the beats at these moments [s]."""
    now, played = [0.0], []
    monkeypatch.setattr("q2q_sim.ros.bag_play_node.monotonic", lambda: now[0])
    player._begin()
    for now[0] in moments:
        before = player._health.ticks
        player._on_beat()
        played.append(player._health.ticks - before)
    return played


def test_a_bag_without_duration_is_looped_once_a_second(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded(tmp_path / "bag")
    with waiting_player(tmp_path / "bag", "loop:=true", "start:=1.99") as player:
        assert played_at(player, monkeypatch, 0.0, 0.5, 0.99, 1.0, 1.5, 2.25) == [1, 0, 0, 1, 0, 1]


def test_after_a_pause_of_the_process_the_playback_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    recorded(tmp_path / "bag")
    with waiting_player(tmp_path / "bag") as player:
        assert played_at(player, monkeypatch, 0.005, 0.255, 60.255, 60.355) == [1, 25, 0, 10]
        assert player._messages.next is not None
        assert player._messages.next.stamp_ns == 360_000_000
    assert "stood still for 60.0 s: continues where it was" in capfd.readouterr().err


def test_a_recorded_clock_gives_way_to_that_of_the_playback(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/clock", "rosgraph_msgs/msg/Clock")
        writer.write_signal("/mocap", 0, synthetic_signal(MocapFrame, 0.0, ("cf1",)))
    for given, topics in (((), {"/clock", "/mocap"}), (("clock:=true",), {"/mocap"})):
        with waiting_player(tmp_path / "bag", *given) as player:
            assert player._writers.keys() == topics
            assert player._node.count_publishers("/clock") == 1


def test_a_tick_without_an_answer_is_reported_until_it_comes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    recorded(tmp_path / "bag")
    message = "no answer on interference to the last tick: check that the node that writes it runs"
    with waiting_player(tmp_path / "bag", "wait_for:=interference") as player:
        now = [0.0]
        monkeypatch.setattr("q2q_sim.ros.bag_play_node.monotonic", lambda: now[0])
        player._begin()
        for now[0], doubt in ((1.9, ""), (2.0, message), (4.0, message)):
            player._on_stall()
            assert player._health.doubts["answer"] == doubt
        assert player._ticks.awaited is not None
        player._on_answer(player._ticks.awaited.data)
        assert player._health.doubts["answer"] == ""
    assert capfd.readouterr().err.count(message) == 1
