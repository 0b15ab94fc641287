"""A recorder's bag holds what it takes, and counts what it lacks, also once its disk is full."""

from pathlib import Path

import pytest
from full_disk import full_after
from serialized_commands import serialized_at

from q2q_model.bag import BagError, BagReader, BagWriter, OfferedQos
from q2q_sim.flight_bag.recorded_bag import RecordedBag

COMMAND = "q2q_msgs/msg/SwarmCommand"


def recorded_in(bag: Path) -> RecordedBag:
    """Return a bag of commands by their header stamps."""
    made = RecordedBag(BagWriter(bag), lambda _: OfferedQos())
    made.add_topic("/command", COMMAND, latched=False)
    return made


def test_a_bag_whose_disk_is_full_says_so_once_and_counts_what_it_lacks(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bag = tmp_path / "bag"
    recorded = recorded_in(bag)
    with full_after(32_768):
        for second in range(400):  # a chunk of some 150 bytes for each
            recorded.take("/command", serialized_at(second))
    with pytest.raises(BagError, match=f"bag {bag} lacks the messages after its disk was full"):
        recorded.close(["/command"])
    stored, said = recorded.health.ticks, capfd.readouterr().err
    assert said.count("\n") == 1
    assert f"cannot write to the bag {bag}: File too large" in said
    assert 50 < stored < 400
    assert recorded.is_full
    assert recorded.health.missed == 399 - stored
    recorded.count_lost("/command", 3)
    recorded.count_lost("/command", 5)
    assert recorded.health.missed == 399 - stored + 5
    reader = BagReader(bag)
    assert "no metadata.yaml" in reader.repairs[0]
    kept = sum(1 for _ in reader.raw())
    assert stored - 2 <= kept <= stored


def test_topics_that_lost_messages_and_that_never_came_are_named(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    recorded = recorded_in(tmp_path / "bag")
    recorded.add_foreign("/map", COMMAND)
    recorded.take("/command", b"\0")  # too short for a stamp
    recorded.take("/command", serialized_at(1))
    recorded.count_lost("/command", 2)
    recorded.close(["/command", "/map"])
    said = capfd.readouterr().err
    assert "bag_record: no message came on /map: " in said
    assert "bag_record: lost 2 messages of /command: this machine is too busy" in said
    assert (recorded.health.ticks, recorded.health.refused, recorded.health.missed) == (1, 1, 2)
    assert "/command: " in recorded.health.last_refusal
    assert [one.topic for one in BagReader(tmp_path / "bag").raw()] == ["/command"]
