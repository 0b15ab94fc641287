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
from q2q_model.bag.storage.own_definition import check_fields
from q2q_model.bag.storage.source import Channel
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.values import SwarmCommand

KIND = "q2q_msgs/msg/SwarmCommand"
OURS = definition_of(KIND)[0]
SIGNAL = random_signal(SwarmCommand, 0, PAIR, np.random.default_rng(0))
MARK = "=" * 80 + "\n"
IDL = rf"""{MARK}IDL: {KIND}
// generated from rosidl_adapter/resource/msg.idl.em
// with input from q2q_msgs/msg/SwarmCommand.msg
// generated code does not contain a copyright notice

#include "std_msgs/msg/Header.idl"

module q2q_msgs {{
  module msg {{
    module SwarmCommand_Constants {{
      @verbatim (language="comment", text=
        "a limit is active")
      const uint8 SATURATED = 1;
    }};
    struct SwarmCommand {{
      @verbatim (language="comment", text=
        "stamp: the tick; frame_id: \"world\", z up")
      std_msgs::msg::Header header;

      sequence<string> names;

      @unit (value="N")
      sequence<double> thrust;

      sequence<double> roll, pitch, yaw_rate;

      sequence<uint8> status;
    }};
  }};
}};

{MARK}IDL: std_msgs/msg/Header
#include "builtin_interfaces/msg/Time.idl"

module std_msgs {{
  module msg {{
    struct Header {{
      builtin_interfaces::msg::Time stamp;

      string frame_id;
    }};
  }};
}};
"""
"""As rosidl writes it."""
OTHER = f"""{MARK}IDL: std_msgs/msg/Other
module std_msgs {{ module msg {{ struct Other {{ int32 x; }}; }}; }};
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


def typed(_: str) -> str:
    """Return an IDL definition with thrust in single precision."""
    return IDL.replace("sequence<double> thrust", "sequence<float> thrust")


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
        (typed, r"field 3 on, as float32\[\] thrust, .*; must be float64\[\] thrust, "),
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


@pytest.mark.parametrize("inside", ["", "bag.db3"])
def test_an_encoding_that_is_not_read_is_named_with_file_and_topic(tmp_path: Path, inside: str) -> None:
    path = write(tmp_path / "bag", OURS, StoragePlugin.SQLITE3)
    with closing(sqlite3.connect(path / "bag.db3")) as table, table:
        table.execute("UPDATE message_definitions SET encoding = 'proto'")
    said = r"\(bag\.db3: the message definition of topic \S+ has encoding 'proto'; ros2msg and ros2idl are"
    with pytest.raises(BagError, match=said):
        BagReader(path / inside)


def test_a_definition_that_cannot_be_read_counts_as_none(tmp_path: Path) -> None:
    bag = BagReader(write(tmp_path / "bag", "float64[ thrust", StoragePlugin.MCAP))
    assert [same_signal(found.signal, SIGNAL) for found in bag.signals()] == [True]


def test_a_definition_of_another_type_is_named(tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", OTHER, StoragePlugin.MCAP)
    with pytest.raises(BagError, match=rf"definition of {KIND} there is of std_msgs/msg/Other; it must hold"):
        list(BagReader(bag).signals())


def test_a_type_whose_name_lacks_its_kind_is_named() -> None:
    channel = Channel("/command", "q2q_msgs/SwarmCommand", OURS, 1)
    with pytest.raises(
        BagError, match=r"topic /command: the definition of q2q_msgs/SwarmCommand there is of"
    ):
        check_fields(Path("bag"), channel)
