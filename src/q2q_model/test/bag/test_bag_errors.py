"""What cannot be written or read is named, and nothing is overwritten."""

from pathlib import Path

import numpy as np
import pytest
from bag_signals import MOCAP, PAIR, random_signal, write_bag
from full_disk import full_after

from q2q_model.bag import (
    BagError,
    BagReader,
    BagWriter,
    read_flight,
)
from q2q_model.signals.values import MocapFrame, SwarmState


def test_nothing_is_overwritten_and_misuse_is_named(tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    with pytest.raises(BagError, match="exists already"):
        BagWriter(tmp_path / "bag")
    with BagWriter(tmp_path / "other") as bag:
        with pytest.raises(BagError, match=r"not announced.*announced: none"):
            bag.write_raw("/mocap", 0, b"")
        with pytest.raises(BagError, match="no definition of message type 'q2q_msgs/msg/Mocap'"):
            bag.add_topic("/mocap", "q2q_msgs/msg/Mocap")
        bag.add_topic("/mocap", MOCAP)
        with pytest.raises(BagError, match="cannot write std_msgs/msg/String to it"):
            bag.add_topic("/mocap", "std_msgs/msg/String")
    with pytest.raises(BagError, match="is closed"):
        bag.write_raw("/mocap", 0, b"")
    bag.close()


def test_what_is_no_bag_or_not_in_it_is_named(tmp_path: Path) -> None:
    notes = tmp_path / "notes.md"
    notes.write_text("no bag")
    with pytest.raises(
        BagError, match=r"notes\.md is not a bag: give a rosbag2 folder or a file \(\.mcap, \.db3, \.bag\)"
    ):
        BagReader(notes)
    with pytest.raises(BagError, match="no bag at"):
        BagReader(tmp_path / "none")
    with pytest.raises(BagError, match="neither metadata"):
        BagReader(tmp_path)
    (tmp_path / "noise.mcap").write_bytes(b"this is no bag")
    with pytest.raises(BagError, match="no message can be recovered"):
        BagReader(tmp_path / "noise.mcap")
    write_bag(tmp_path / "bag", 5, {"/state": SwarmState})
    with pytest.raises(BagError, match="has no topic /mocap; it has /state"):
        list(BagReader(tmp_path / "bag").raw({"/mocap"}))
    with pytest.raises(BagError, match=r"no message on mocap; it has state \(5\)"):
        read_flight(tmp_path / "bag")
    assert np.isfinite(read_flight(tmp_path / "bag", required=("state",)).vel).all()


def test_an_empty_bag_is_a_bag_without_a_flight(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/mocap", MOCAP)
    assert BagReader(tmp_path / "bag").topics == {"/mocap": MOCAP}
    assert list(BagReader(tmp_path / "bag").raw()) == []
    with pytest.raises(BagError, match=r"no message on mocap; it has mocap \(0\)"):
        read_flight(tmp_path / "bag")


def test_a_full_disk_is_named_and_what_was_written_can_be_read(tmp_path: Path) -> None:
    """No file may grow beyond 32 KiB, which fails as a full disk does; the index is never written."""
    rng, stored = np.random.default_rng(4), []
    bag = BagWriter(tmp_path / "bag")

    def fill() -> None:
        for second in range(1000):
            bag.write_signal("/mocap", second * 10**9, random_signal(MocapFrame, second, PAIR, rng))
            stored.append(second)

    with full_after(32_768), pytest.raises(BagError, match=r"cannot write to the bag .*: File too large"):
        fill()
    bag.close()
    with pytest.raises(BagError, match="is closed"):
        bag.flush()
    reader = BagReader(tmp_path / "bag")
    assert "no metadata.yaml" in reader.repairs[0]
    kept = sum(1 for _ in reader.raw())
    assert 30 < len(stored) - 2 <= kept <= len(stored)


def test_a_folder_that_cannot_be_written_is_named() -> None:
    with pytest.raises(BagError, match="cannot create the bag folder /sys/bag: "):
        BagWriter("/sys/bag")
