"""Tests of bags: round trips, an independent reader and writer, errors that name the fault."""

import resource
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import yaml
from bag_signals import PAIR, STEP_NS, random_signal, same_signal, write_bag
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer as ForeignWriter

from q2q_model.bag import (
    BagError,
    BagReader,
    BagRepairWarning,
    BagWriter,
    OfferedQos,
    read_flight,
)
from q2q_model.bag.storage.definitions import definition_of
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.values import MocapFrame, SwarmCommand, SwarmState

KINDS = list(LAYOUTS)
MOCAP = "q2q_msgs/msg/MocapFrame"


@given(st.integers(0, 2**32 - 1), st.sampled_from(KINDS), st.integers(0, 5), st.sampled_from([0, 7]))
@settings(max_examples=20, deadline=None)
def test_every_signal_survives_the_bag(seed: int, kind: type[Signal], vehicles: int, later_ns: int):
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
def test_a_bag_is_compressed_or_not_and_reads_the_same(tmp_path: Path, compress: bool, stored: str):
    one = random_signal(MocapFrame, 3, PAIR, np.random.default_rng(0))
    with BagWriter(tmp_path / "bag", compress=compress) as bag:
        bag.write_signal("/mocap", 3 * STEP_NS, one)
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert [chunk.compression for chunk in summary.chunk_indexes] == [stored]
    (found,) = BagReader(tmp_path / "bag").signals()
    assert same_signal(found.signal, one)


def test_an_independent_reader_reads_every_message_and_number(tmp_path: Path):
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


def test_a_bag_of_an_independent_writer_is_read(tmp_path: Path):
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


def test_the_folder_looks_as_ros_2_jazzy_writes_it(tmp_path: Path):
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


def test_a_flight_is_joined_by_stamp_and_missing_is_nan(tmp_path: Path):
    rng = np.random.default_rng(1)
    frames, commands = {}, {}
    with BagWriter(tmp_path / "bag") as bag:
        for tick in range(50):
            names = PAIR if tick % 5 else PAIR[1:]
            frames[tick] = random_signal(MocapFrame, tick, names, rng)
            bag.write_signal("/room/mocap", tick * STEP_NS, frames[tick])
            if tick % 3 == 0:  # commands come later than the ticks they answer
                commands[tick] = random_signal(SwarmCommand, tick, PAIR[::-1], rng)
                bag.write_signal("/room/command", tick * STEP_NS + 4_000_000, commands[tick])
    flight = read_flight(tmp_path / "bag")
    assert flight.names == PAIR[::-1]  # command names the whole swarm
    assert np.array_equal(flight.t, [tick * STEP_NS * 1e-9 for tick in range(50)])
    for tick in range(50):
        assert np.array_equal(flight.mocap_pos[tick, 0], frames[tick].pos[-1])
        assert np.isnan(flight.mocap_pos[tick, 1]).all() == (tick % 5 == 0)
        if tick in commands:
            assert np.array_equal(flight.thrust[tick], commands[tick].thrust)
        else:
            assert np.isnan(flight.thrust[tick]).all()
    assert np.isnan(flight.pos).all()


def test_nothing_is_overwritten_and_misuse_is_named(tmp_path: Path):
    (tmp_path / "bag").mkdir()
    with pytest.raises(BagError, match="exists already"):
        BagWriter(tmp_path / "bag")
    with BagWriter(tmp_path / "other") as bag:
        with pytest.raises(BagError, match=r"not announced.*announced: none"):
            bag.write_raw("/mocap", 0, b"")
        with pytest.raises(BagError, match="no definition of message type 'q2q_msgs/msg/Mocap'"):
            bag.add_topic("/mocap", "q2q_msgs/msg/Mocap")
        bag.add_topic("/mocap", MOCAP)
        with pytest.raises(BagError, match="cannot hold"):
            bag.add_topic("/mocap", "std_msgs/msg/String")
    with pytest.raises(BagError, match="is closed"):
        bag.write_raw("/mocap", 0, b"")
    bag.close()


def test_what_is_no_bag_or_not_in_it_is_named(tmp_path: Path):
    notes = tmp_path / "notes.md"
    notes.write_text("no bag")
    with pytest.raises(
        BagError, match=r"notes\.md is no bag: give a rosbag2 folder or a file \(\.mcap, \.db3, \.bag\)"
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


def test_an_empty_bag_is_a_bag_without_a_flight(tmp_path: Path):
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/mocap", MOCAP)
    assert BagReader(tmp_path / "bag").topics == {"/mocap": MOCAP}
    assert list(BagReader(tmp_path / "bag").raw()) == []
    with pytest.raises(BagError, match=r"no message on mocap; it has mocap \(0\)"):
        read_flight(tmp_path / "bag")


def test_clocks_that_never_meet_are_refused_with_both_spans(tmp_path: Path):
    rng = np.random.default_rng(2)
    with BagWriter(tmp_path / "bag") as bag:
        for tick in range(20):
            bag.write_signal("/mocap", tick * STEP_NS, random_signal(MocapFrame, tick, PAIR, rng))
            late = random_signal(SwarmCommand, 170_000_000 + tick, PAIR, rng)
            bag.write_signal("/command", tick * STEP_NS, late)
    with pytest.raises(BagError, match=r"command \(1700000\.000 to .*mocap.*clocks are mixed"):
        read_flight(tmp_path / "bag")


def test_frames_that_all_have_one_stamp_are_no_flight(tmp_path: Path):
    rng = np.random.default_rng(2)
    with BagWriter(tmp_path / "bag") as bag:
        for tick in range(100):
            bag.write_signal("/mocap", tick * STEP_NS, random_signal(MocapFrame, 0, PAIR, rng))
    with pytest.raises(BagError, match=r"all 100 messages on mocap are stamped 0 s: stamp each"):
        read_flight(tmp_path / "bag")


def test_strays_repeats_and_disorder_are_stated(tmp_path: Path):
    rng = np.random.default_rng(3)
    with BagWriter(tmp_path / "bag") as bag:
        for place, tick in enumerate((0, 1, 3, 2, 4, 4)):
            bag.write_signal("/mocap", place * STEP_NS, random_signal(MocapFrame, tick, PAIR, rng))
        for tick in (4, 5):
            bag.write_signal("/state", 10 * STEP_NS, random_signal(SwarmState, tick, PAIR, rng))
            bag.write_signal("/command", 10 * STEP_NS, random_signal(SwarmCommand, tick, PAIR, rng))
    with warnings.catch_warnings(record=True) as lines:
        warnings.simplefilter("always")
        flight = read_flight(tmp_path / "bag")
    text = " | ".join(str(one.message) for one in lines)
    assert "1 of 2 messages on state match no tick" in text
    assert "command" not in text  # a live controller commands on after the last tick
    assert "1 repeated stamp on mocap" in text
    assert "stamps on mocap are out of order" in text
    assert len(flight.t) == 5


def test_commands_of_one_controller_a_vehicle_join_in_a_tick_and_are_no_repeats(tmp_path: Path):
    rng = np.random.default_rng(4)
    sent = [random_signal(SwarmCommand, tick, (name,), rng) for tick in range(3) for name in PAIR]
    with BagWriter(tmp_path / "bag") as bag:
        for tick in range(3):
            bag.write_signal("/mocap", tick * STEP_NS, random_signal(MocapFrame, tick, PAIR, rng))
        for place, command in enumerate(sent):
            bag.write_signal("/command", place * STEP_NS, command)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        flight = read_flight(tmp_path / "bag")
    assert flight.thrust.ravel().tolist() == [command.thrust[0] for command in sent]


@pytest.mark.parametrize("metadata", [None, ""])
@pytest.mark.parametrize("parts", [1, 3])
@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_bag_without_metadata_is_that_of_its_whole_files(
    tmp_path: Path, storage: str, parts: int, metadata: str | None
) -> None:
    from rosbags.rosbag2 import StoragePlugin, Writer

    from q2q_model.bag.storage.definitions import jazzy_types
    from q2q_model.signals.cdr.cdr_writer import encode

    rng, bag = np.random.default_rng(0), tmp_path / "bag"
    frames = [random_signal(MocapFrame, tick, PAIR, rng) for tick in range(30)]
    bag.mkdir()
    plugin, size = StoragePlugin[storage], len(frames) // parts
    for part in range(parts):
        with Writer(tmp_path / f"part{part}", version=8, storage_plugin=plugin) as writer:
            connection = writer.add_connection("/mocap", MOCAP, typestore=jazzy_types())
            for tick in range(part * size, (part + 1) * size):
                writer.write(connection, tick * STEP_NS, encode(frames[tick], tick * STEP_NS))
        (file,) = (one for one in (tmp_path / f"part{part}").iterdir() if one.suffix in {".mcap", ".db3"})
        file.rename(bag / f"bag_{part}{file.suffix}")
    if metadata is not None:
        (bag / "metadata.yaml").write_text(metadata)
    reader = BagReader(bag)
    assert len(reader.repairs) == 1
    assert f"bag_{parts - 1}" in reader.repairs[0]
    assert [(one.topic, one.count) for one in reader.channels] == [("/mocap", 30)]
    with pytest.warns(BagRepairWarning, match="whole"):
        flight = read_flight(bag)
    assert np.array_equal(flight.mocap_pos, np.stack([frame.pos for frame in frames]))


def test_an_sqlite_bag_is_read(tmp_path: Path):
    from rosbags.rosbag2 import StoragePlugin, Writer

    from q2q_model.bag.storage.definitions import jazzy_types
    from q2q_model.signals.cdr.cdr_writer import encode

    rng = np.random.default_rng(0)
    frames = [random_signal(MocapFrame, tick, PAIR, rng) for tick in range(20)]
    with Writer(tmp_path / "old", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection("/mocap", MOCAP, typestore=jazzy_types())
        for tick, frame in enumerate(frames):
            writer.write(connection, tick * STEP_NS, encode(frame, tick * STEP_NS))
    flight = read_flight(tmp_path / "old")
    assert np.array_equal(flight.mocap_pos, np.stack([frame.pos for frame in frames]))


def test_a_full_disk_is_named_and_what_was_written_can_be_read(tmp_path: Path):
    """No file may grow beyond 32 KiB, which fails as a full disk does; the index is never written."""
    rng, stored = np.random.default_rng(4), []
    bag = BagWriter(tmp_path / "bag")

    def fill() -> None:
        for second in range(1000):
            bag.write_signal("/mocap", second * 10**9, random_signal(MocapFrame, second, PAIR, rng))
            stored.append(second)

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (32_768, before[1]))
    try:
        with pytest.raises(BagError, match=r"cannot write to the bag .*: File too large"):
            fill()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    bag.close()
    with pytest.raises(BagError, match="is closed"):
        bag.flush()
    reader = BagReader(tmp_path / "bag")
    assert "no metadata.yaml" in reader.repairs[0]
    kept = sum(1 for _ in reader.raw())
    assert 30 < len(stored) - 2 <= kept <= len(stored)


def test_a_folder_that_cannot_be_written_is_named():
    with pytest.raises(BagError, match="cannot create the bag folder /sys/bag: "):
        BagWriter("/sys/bag")
