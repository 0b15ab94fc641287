"""Damaged bags are read as far as they are sound, and their repairs are reported."""

import io
import os
import signal as signals_of_unix
import subprocess
import sys
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from bag_signals import PAIR, same_signal, write_bag
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.data_stream import RecordBuilder
from mcap.reader import make_reader
from mcap.records import Channel, Header, McapRecord, Message, Schema
from mcap.writer import Writer

from q2q_model.bag import (
    BagError,
    BagReader,
    BagRepairWarning,
    read_flight,
)
from q2q_model.bag.storage.definitions import definition_of
from q2q_model.signals.values import MocapFrame, SwarmCommand

CHUNK_INDEX, UNKNOWN = 0x08, 0x7F
"""Kinds of records."""


@pytest.mark.parametrize(
    ("left_out", "report"),
    [
        (("use_statistics", "repeat_channels", "repeat_schemas"), "its summary has no channels"),
        (("repeat_channels", "repeat_schemas"), "0 of 1 channels are in the summary"),
        (("repeat_channels",), "0 of 1 channels are in the summary"),
        (("repeat_schemas",), "the summary lacks types of its channels"),
    ],
)
def test_a_file_whose_summary_lacks_its_channels_is_read_whole_and_said(
    left_out: tuple[str, ...], report: str, tmp_path: Path
):
    written = write_bag(tmp_path / "bag", 30, {"/mocap": MocapFrame})["/mocap"]
    terse = tmp_path / "terse.mcap"
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream, terse.open("wb") as out:
        writer = Writer(out, **dict.fromkeys(left_out, False))
        writer.start("ros2")
        for schema, channel, message in make_reader(stream).iter_messages():
            assert schema is not None
            if message.log_time == 0:
                kind = writer.register_schema(schema.name, schema.encoding, schema.data)
                number = writer.register_channel(channel.topic, channel.message_encoding, kind)
            writer.add_message(number, message.log_time, message.data, message.publish_time)
        writer.finish()
    reader = BagReader(terse)
    assert reader.topics == {"/mocap": "q2q_msgs/msg/MocapFrame"}
    assert f"{report}; recovered 30 messages" in reader.repairs[0]
    assert all(same_signal(a.signal, b) for a, b in zip(reader.signals(), written, strict=True))


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9, 0.999])
def test_a_bag_cut_off_is_read_up_to_the_cut_and_said(tmp_path: Path, share: float):
    written = write_bag(tmp_path / "bag", 1000, {"/mocap": MocapFrame})["/mocap"]
    file = tmp_path / "bag" / "bag_0.mcap"
    whole = file.read_bytes()
    file.write_bytes(whole[: int(share * len(whole))])
    reader = BagReader(tmp_path / "bag")
    assert any("truncated" in repair for repair in reader.repairs)
    found = [one.signal for one in reader.signals()]
    assert all(same_signal(a, b) for a, b in zip(found, written, strict=False))
    # ten chunks of 100 messages, the index behind them is less than a tenth of the file
    assert len(found) >= 100 * int(share * 10 * 0.99)
    with pytest.warns(BagRepairWarning):
        assert len(read_flight(tmp_path / "bag").t) == len(found)


def test_a_bag_of_a_killed_recorder_is_read_up_to_the_last_second(tmp_path: Path):
    program = (
        "import sys; sys.path.insert(0, sys.argv[2]); import numpy as np\n"
        "from bag_signals import random_signal\n"
        "from q2q_model.bag import BagWriter\n"
        "from q2q_model.signals.values import MocapFrame\n"
        "bag, rng = BagWriter(sys.argv[1]), np.random.default_rng(0)\n"
        "for tick in range(350):\n"
        "    bag.write_signal('/mocap', tick * 10_000_000, random_signal(MocapFrame, tick, ('cf1',), rng))\n"
        "print('written', flush=True); sys.stdin.read()\n"
    )
    folder = str(Path(__file__).parents[1])
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command, pipe = [sys.executable, "-c", program, str(tmp_path / "bag"), folder], subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, env=environment) as recorder:
        assert recorder.stdout is not None
        assert recorder.stdout.readline() == b"written\n"
        recorder.send_signal(signals_of_unix.SIGKILL)
    with pytest.warns(BagRepairWarning, match="not closed"):
        flight = read_flight(tmp_path / "bag")
    assert len(flight.t) == 300  # three closed chunks of a second at 100 Hz; half a second was open


def test_a_damaged_chunk_is_noticed(tmp_path: Path):
    write_bag(tmp_path / "bag", 300, {"/mocap": MocapFrame})
    file = tmp_path / "bag" / "bag_0.mcap"
    spoiled = bytearray(file.read_bytes())
    spoiled[3000] ^= 0x10  # within the first chunk's data
    file.write_bytes(spoiled)
    with pytest.raises(BagError, match="is damaged after 0 messages"):
        read_flight(tmp_path / "bag")


def test_a_chunk_that_the_index_has_lost_is_read_and_said(tmp_path: Path):
    write_bag(tmp_path / "bag", 300, {"/mocap": MocapFrame})
    file = tmp_path / "bag" / "bag_0.mcap"
    spoiled = bytearray(file.read_bytes())
    spoiled[place_of_record(spoiled, CHUNK_INDEX)] = UNKNOWN
    file.write_bytes(spoiled)
    with pytest.warns(BagRepairWarning, match="of 3 chunks have an index"):
        flight = read_flight(tmp_path / "bag")
    assert len(flight.t) == 300


def place_of_record(data: bytearray, wanted: int) -> int:
    """Return where the first record of a kind begins in the summary of an MCAP file (mcap.dev)."""
    place = int.from_bytes(data[-28:-20], "little")  # footer: summary start, offset start, CRC, magic
    while data[place] != wanted:
        place += 9 + int.from_bytes(data[place + 1 : place + 9], "little")
    return place


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.booleans(), st.booleans())
@settings(max_examples=60, deadline=None)
def test_damaged_bytes_give_a_flight_or_a_bag_error_and_nothing_else(
    seed: int, hits: int, cut: bool, closed: bool
):
    rng = np.random.default_rng(seed)
    spoiled = bytearray(WHOLE)
    for place in rng.integers(0, len(spoiled), hits):
        spoiled[place] = rng.integers(0, 256)
    if cut:
        del spoiled[int(rng.integers(0, len(spoiled))) :]
    with TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as lines:
        warnings.simplefilter("always")
        (Path(folder) / "bag").mkdir()
        (Path(folder) / "bag" / "bag_0.mcap").write_bytes(spoiled)
        if closed:
            (Path(folder) / "bag" / "metadata.yaml").write_text(METADATA)
        try:
            flight = read_flight(Path(folder) / "bag")
        except BagError:
            return
    complete = (
        set(flight.names) == set(PAIR) and len(flight.t) == 250 and not np.isnan(flight.mocap_pos).any()
    )
    assert complete or any(issubclass(one.category, BagRepairWarning) for one in lines)


def _whole_bag() -> tuple[bytes, str]:
    with TemporaryDirectory() as folder:
        write_bag(Path(folder) / "bag", 250, {"/mocap": MocapFrame, "/command": SwarmCommand})
        bag = Path(folder) / "bag"
        return (bag / "bag_0.mcap").read_bytes(), (bag / "metadata.yaml").read_text()


WHOLE, METADATA = _whole_bag()


def test_metadata_nested_too_deeply_are_read_around(tmp_path: Path) -> None:
    """They ended the process in the C library's recursion."""
    (tmp_path / "bag_0.mcap").write_bytes(WHOLE)
    (tmp_path / "metadata.yaml").write_text("[" * 100_000)
    reader = BagReader(tmp_path)
    assert reader.repairs
    assert sum(1 for _ in reader.raw()) == 500


def test_the_fuzzed_file_is_whole():
    assert make_reader(io.BytesIO(WHOLE)).get_summary().statistics.message_count == 500


def test_a_cut_bag_whose_channel_was_given_another_topic_keeps_what_came_under_the_first(
    tmp_path: Path,
) -> None:
    """Found by fuzzing: it raised a KeyError."""
    builder = RecordBuilder()
    text = definition_of("q2q_msgs/msg/MocapFrame")[0].encode()
    records: tuple[McapRecord, ...] = (
        Header("ros2", ""),
        Schema(id=1, data=text, encoding="ros2msg", name="q2q_msgs/msg/MocapFrame"),
        Channel(id=1, topic="/first", message_encoding="cdr", metadata={}, schema_id=1),
        Message(channel_id=1, log_time=5, data=b"", publish_time=5, sequence=0),
        Channel(id=1, topic="/second", message_encoding="cdr", metadata={}, schema_id=1),
    )
    for record in records:
        record.write(builder)
    path = tmp_path / "cut.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + builder.end())
    reader = BagReader(path)
    assert reader.repairs[0].endswith("recovered 1 message")
    assert reader.topics == {"/first": "q2q_msgs/msg/MocapFrame"}
    assert [(found.topic, found.stamp_ns) for found in reader.raw()] == [("/first", 5)]
