"""A bag whose definition of a q2q_msgs type has other fields is refused by name, never misread."""

import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from bag_signals import PAIR, random_signal, same_signal
from rosbags.rosbag2 import StoragePlugin, Writer

from q2q_model.bag import BagError, BagReader, TopicMap, read_flight, read_mapped_flight
from q2q_model.bag.storage.definitions import definition_of
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import SwarmCommand

KIND = "q2q_msgs/msg/SwarmCommand"
OURS = definition_of(KIND)[0]
SIGNAL = random_signal(SwarmCommand, 0, PAIR, np.random.default_rng(0))
IDL = f"""{"=" * 80}
IDL: {KIND}
module q2q_msgs {{ module msg {{ struct SwarmCommand {{
  std_msgs::msg::Header header;
  sequence<string> names;
  sequence<double> thrust, roll, pitch, yaw_rate;
  sequence<uint8> status;
}}; }}; }};
"""


def inserted(text: str) -> str:
    """Return a definition with a field before the thrust."""
    return text.replace("float64[] thrust", "float64[] battery\nfloat64[] thrust")


def swapped(text: str) -> str:
    """Return a definition with thrust and roll in each other's place."""
    return text.replace("float64[] thrust\nfloat64[] roll", "float64[] roll\nfloat64[] thrust")


def narrowed(text: str) -> str:
    """Return a definition with thrust in single precision."""
    return text.replace("float64[] thrust", "float32[] thrust")


def older(text: str) -> str:
    """Return a definition without its last field."""
    return text.replace("uint8[] status\n", "")


def appended(text: str) -> str:
    """Return a definition with a further field at its end, and comments."""
    return text.replace("uint8[] status\n", "uint8[] status  # N\nfloat64[] battery  # N [V]\n")


def write(path: Path, text: str, storage: StoragePlugin) -> Path:
    """Write one command under a definition of its type."""
    with Writer(path, version=9, storage_plugin=storage) as writer:
        topic = writer.add_connection("/command", KIND, msgdef=text, rihs01=definition_of(KIND)[1])
        writer.write(topic, 0, encode(SIGNAL, 0))
    return path


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize(
    ("change", "differs"),
    [
        (inserted, r"field 3 on, as float64\[\] battery, float64\[\] thrust, .*; must be float64\[\] thrust"),
        (swapped, r"field 3 on, as float64\[\] roll, float64\[\] thrust, .*; must be float64\[\] thrust, "),
        (narrowed, r"field 3 on, as float32\[\] thrust, .*; must be float64\[\] thrust, "),
        (older, r"field 7 on, as empty; must be uint8\[\] status: read the bag with the version"),
    ],
)
def test_other_fields_are_named_with_topic_and_type(
    tmp_path: Path, storage: StoragePlugin, change: Callable[[str], str], differs: str
) -> None:
    bag = write(tmp_path / "bag", change(OURS), storage)
    reads: list[Callable[[], object]] = [
        lambda: list(BagReader(bag).signals()),
        lambda: BagReader(bag).rows({"/command"}),
        lambda: read_flight(bag, required=("command",)),
        lambda: read_mapped_flight(bag, TopicMap(signals={"command": "/command"})),
    ]
    for read in reads:
        with pytest.raises(BagError, match=rf"topic /command: {KIND} is defined there, from {differs}"):
            read()
    assert BagReader(bag).topics == {"/command": KIND}


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize("text", [OURS, appended(OURS), IDL])
def test_the_same_fields_are_read_whatever_their_definition_looks_like(
    tmp_path: Path, text: str, storage: StoragePlugin
) -> None:
    bag = BagReader(write(tmp_path / "bag", text, storage))
    assert [same_signal(found.signal, SIGNAL) for found in bag.signals()] == [True]


def test_a_bag_without_a_definition_is_read_by_that_of_q2q(tmp_path: Path) -> None:
    path = write(tmp_path / "bag", OURS, StoragePlugin.SQLITE3)
    with closing(sqlite3.connect(path / "bag.db3")) as table, table:
        table.execute("DELETE FROM message_definitions")
    bag = BagReader(path)
    assert bag.channels[0].definition == ""
    assert [same_signal(found.signal, SIGNAL) for found in bag.signals()] == [True]


def test_a_definition_that_is_none_is_named(tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", "float64[ thrust", StoragePlugin.MCAP)
    with pytest.raises(BagError, match=f"the definition of {KIND} cannot be read"):
        list(BagReader(bag).signals())
