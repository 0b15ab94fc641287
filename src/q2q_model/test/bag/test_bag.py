"""A bag holds what was written, as ROS 2 Jazzy and independent readers and writers have it."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import yaml
from bag_signals import MOCAP, PAIR, STEP_NS, random_signal, same_signal, write_bag
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer as ForeignWriter

from q2q_model.bag import (
    BagReader,
    BagWriter,
    OfferedQos,
    read_flight,
)
from q2q_model.bag.storage.definitions import definition_of
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.values import MocapFrame

KINDS = list(LAYOUTS)


@given(st.integers(0, 2**32 - 1), st.sampled_from(KINDS), st.integers(0, 5), st.sampled_from([0, 7]))
@settings(max_examples=20, deadline=None)
def test_every_signal_survives_the_bag(seed: int, kind: type[Signal], vehicles: int, later_ns: int) -> None:
    rng = np.random.default_rng(seed)
    # a float time holds whole nanoseconds for 26 days; a wall clock's needs the stamp beside it
    tick = int(rng.integers(0, 2**51 // STEP_NS if later_ns else 2**30 * 100))
    one = random_signal(kind, tick, tuple(f"cf{k}" for k in range(vehicles)), rng)
    with TemporaryDirectory() as folder:
        with BagWriter(Path(folder) / "bag") as bag:
            bag.write_signal("/topic", tick * STEP_NS + later_ns, one)
        (found,) = BagReader(Path(folder) / "bag").signals()
    assert found.topic == "/topic"
    assert found.stamp_ns == tick * STEP_NS + later_ns
    assert same_signal(found.signal, one)


@pytest.mark.parametrize(("compress", "stored"), [(True, "zstd"), (False, "")])
def test_a_bag_is_compressed_or_not_and_reads_the_same(tmp_path: Path, compress: bool, stored: str) -> None:
    one = random_signal(MocapFrame, 3, PAIR, np.random.default_rng(0))
    with BagWriter(tmp_path / "bag", compress=compress) as bag:
        bag.write_signal("/mocap", 3 * STEP_NS, one)
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert [chunk.compression for chunk in summary.chunk_indexes] == [stored]
    (found,) = BagReader(tmp_path / "bag").signals()
    assert same_signal(found.signal, one)


def test_an_independent_reader_reads_every_message_and_number(tmp_path: Path) -> None:
    written = write_bag(tmp_path / "bag", 120, {kind.__name__: kind for kind in KINDS})
    counts = dict.fromkeys(written, 0)
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, record, message in reader.iter_decoded_messages():
            own = written[channel.topic][counts[channel.topic]]
            assert schema.encoding == "ros2msg"
            assert record.log_time == counts[channel.topic] * STEP_NS
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == round(own.t * 1e9)
            assert tuple(message.names) == PAIR
            for column in LAYOUTS[type(own)].columns:
                read = getattr(message, column.field)
                read = list(read) if isinstance(read, bytes) else read
                assert np.array_equal(read, getattr(own, column.attribute).ravel())
            counts[channel.topic] += 1
    assert set(counts.values()) == {120}


def test_a_bag_of_an_independent_writer_is_read(tmp_path: Path) -> None:
    definition, _ = definition_of(MOCAP)
    with (tmp_path / "foreign.mcap").open("wb") as stream, ForeignWriter(stream) as writer:
        schema = writer.register_msgdef(MOCAP, definition)
        for tick in range(30):
            message = {
                "header": {"stamp": {"sec": 0, "nanosec": tick * STEP_NS}, "frame_id": "world"},
                "names": ["cf1"],
                "position": [0.01 * tick, 2.0, 3.0],
                "orientation": [0.0, 0.0, 0.0, 1.0],
            }
            writer.write_message("/mocap", schema, message, log_time=tick * STEP_NS, publish_time=0)
    flight = read_flight(tmp_path / "foreign.mcap")
    assert flight.names == ("cf1",)
    assert np.allclose(flight.mocap_pos[:, 0, 0], 0.01 * np.arange(30), atol=0)
    assert np.array_equal(flight.mocap_pos[:, 0, 1:], np.tile([2.0, 3.0], (30, 1)))


def test_the_folder_looks_as_ros_2_jazzy_writes_it(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "mine") as bag:
        bag.add_topic("/mocap", MOCAP)
        bag.add_topic("/plan", "q2q_msgs/msg/Plan", OfferedQos(transient_local=True))
        bag.write_signal("/mocap", 5, random_signal(MocapFrame, 0, PAIR, np.random.default_rng(0)))
    info = yaml.safe_load((tmp_path / "mine" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (info["version"], info["storage_identifier"], info["compression_format"]) == (9, "mcap", "")
    assert info["relative_file_paths"] == ["mine_0.mcap"]
    assert info["message_count"] == 1
    entries = [entry["topic_metadata"] for entry in info["topics_with_message_count"]]
    topics = {entry["name"]: entry for entry in entries}
    assert topics["/mocap"]["type_description_hash"] == definition_of(MOCAP)[1]
    assert topics["/plan"]["offered_qos_profiles"][0]["durability"] == "transient_local"
    with (tmp_path / "mine" / "mine_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
    assert {chunk.compression for chunk in summary.chunk_indexes} == {"zstd"}
    assert all("offered_qos_profiles" in channel.metadata for channel in summary.channels.values())
