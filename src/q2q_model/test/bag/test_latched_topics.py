"""A bag of any kind knows which of its topics were latched."""

from pathlib import Path

import numpy as np
import pytest
from bag_signals import PAIR, STEP_NS, random_signal
from rosbags.interfaces import Qos
from rosbags.rosbag2 import StoragePlugin, Writer

from q2q_model.bag import BagReader, BagWriter, OfferedQos
from q2q_model.bag.storage.definitions import jazzy_types
from q2q_model.bag.storage.latched import channel_is_latched
from q2q_model.bag.writer import _profile
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import MocapFrame

KIND = "q2q_msgs/msg/MocapFrame"
OFFERS: dict[str, list[OfferedQos]] = {
    "/latched": [OfferedQos(transient_local=True), OfferedQos(transient_local=True)],
    "/volatile": [OfferedQos()],
    "/mixed": [OfferedQos(transient_local=True), OfferedQos()],
    "/unknown": [],
}
"""What the publishers of a topic offered."""


def profiles(topic: str) -> list[Qos]:
    """Return the qualities of service that were offered on a topic."""
    return [_profile(one) for one in OFFERS[topic]]


@pytest.mark.parametrize(
    ("version", "storage"), [(9, StoragePlugin.MCAP), (8, StoragePlugin.MCAP), (8, StoragePlugin.SQLITE3)]
)
def test_a_topic_is_latched_if_all_its_publishers_latched_it(
    tmp_path: Path, version: int, storage: StoragePlugin
) -> None:
    data = encode(random_signal(MocapFrame, 0, PAIR, np.random.default_rng(0)), 0)
    with Writer(tmp_path / "bag", version=version, storage_plugin=storage) as writer:
        for topic in OFFERS:
            offered = profiles(topic)
            channel = writer.add_connection(
                topic, KIND, typestore=jazzy_types(), offered_qos_profiles=offered
            )
            writer.write(channel, 1, data)
    assert BagReader(tmp_path / "bag").latched == {"/latched"}


def test_a_bag_that_was_cut_off_knows_it_too(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/plan", KIND, OfferedQos(transient_local=True))
        for tick in range(300):
            for topic in ("/plan", "/mocap"):
                bag.write_signal(topic, tick * STEP_NS, random_signal(MocapFrame, tick, PAIR, rng))
    assert BagReader(tmp_path / "bag").latched == {"/plan"}
    file = tmp_path / "bag" / "bag_0.mcap"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    cut = BagReader(tmp_path / "bag")
    assert cut.is_cut
    assert cut.latched == {"/plan"}


@pytest.mark.parametrize(
    ("durability", "latched"), [("1", True), ("2", False), ("transient_local", True), ("volatile", False)]
)
def test_durabilities_are_numbers_until_iron_and_names_since(durability: str, *, latched: bool) -> None:
    offered = f"- history: 3\n  depth: 0\n  reliability: 1\n  durability: {durability}\n  liveliness: 1\n"
    assert channel_is_latched({"offered_qos_profiles": offered}) == latched
    assert not channel_is_latched({"offered_qos_profiles": offered + "- durability: 2\n"})
    assert not channel_is_latched({})
