"""Our bytes are the bytes that others read and write."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from q2q_model.signals.cdr.cdr_format import BadMessageError, header_stamp_ns
from q2q_model.signals.cdr.cdr_reader import SignalReader, decode
from q2q_model.signals.cdr.cdr_writer import encode, encode_stamp
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.stamps import END_S
from q2q_model.signals.values import MocapFrame, SwarmImu, SwarmState

SIGNALS = list(LAYOUTS)
NAMES = st.lists(st.text("abcf123", min_size=1, max_size=9), max_size=5, unique=True).map(tuple)
STAMPS = st.integers(0, END_S * 10**9 - 1)


def typestore() -> Typestore:
    store = get_typestore(Stores.ROS2_JAZZY)
    for layout in LAYOUTS.values():
        arrays = "\n".join(
            f"{'uint8' if column.field == 'status' else 'float64'}[] {column.field}"
            for column in layout.columns
        )
        text = f"std_msgs/Header header\nstring[] names\n{arrays}\n"
        store.register(get_types_from_msg(text, f"q2q_msgs/msg/{layout.message}"))
    return store


STORE = typestore()


def made(kind: type[Signal], names: tuple[str, ...], stamp_ns: int) -> Signal:
    rng = np.random.default_rng(len(names))
    arrays = {
        column.attribute: rng.integers(0, 3, len(names)).astype(np.uint8)
        if column.field == "status"
        else rng.normal(size=(len(names), column.width) if column.width > 1 else len(names))
        for column in LAYOUTS[kind].columns
    }
    return kind(t=stamp_ns * 1e-9, names=names, **arrays)


@given(st.sampled_from(SIGNALS), NAMES, STAMPS)
def test_an_independent_reader_reads_what_we_write(
    kind: type[Signal], names: tuple[str, ...], stamp_ns: int
) -> None:
    signal = made(kind, names, stamp_ns)
    message = STORE.deserialize_cdr(encode(signal, stamp_ns), f"q2q_msgs/msg/{LAYOUTS[kind].message}")
    assert tuple(message.names) == names
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == divmod(stamp_ns, 10**9)
    assert message.header.frame_id == ("body" if kind is SwarmImu else "world")
    for column in LAYOUTS[kind].columns:
        expected = getattr(signal, column.attribute).ravel()
        np.testing.assert_array_equal(getattr(message, column.field), expected)


@given(st.sampled_from(SIGNALS), NAMES, STAMPS)
def test_we_read_what_an_independent_writer_writes(
    kind: type[Signal], names: tuple[str, ...], stamp_ns: int
) -> None:
    signal = made(kind, names, stamp_ns)
    type_name = f"q2q_msgs/msg/{LAYOUTS[kind].message}"
    data = bytes(STORE.serialize_cdr(STORE.deserialize_cdr(encode(signal, stamp_ns), type_name), type_name))
    back = decode(data, kind)
    assert header_stamp_ns(data) == stamp_ns
    assert back.names == names
    for entry in fields(kind):
        np.testing.assert_array_equal(getattr(back, entry.name), getattr(signal, entry.name))


@given(st.data())
def test_damaged_bytes_are_refused_and_never_anything_else(data: st.DataObject) -> None:
    whole = bytearray(encode(made(SwarmState, ("cf1", "cf2"), 10**9), 10**9))
    for _ in range(data.draw(st.integers(1, 4))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    cut = bytes(whole[: data.draw(st.integers(0, len(whole)))])
    try:
        names = decode(cut, SwarmState).names
    except BadMessageError:
        return
    assert len(cut) >= len(whole) - 1 or not names  # without names, arrays are not read


@pytest.mark.parametrize("kind", SIGNALS)
def test_what_a_node_receives_is_the_same_and_writable(kind: type[Signal]) -> None:
    signal, reader = made(kind, ("cf1", "cf2"), 10**9), SignalReader(kind)
    for _ in range(2):  # the second one by the offsets of the first
        received = reader.received(encode(signal, 10**9))
        assert (received.t, received.names) == (1.0, signal.names)
        for column in LAYOUTS[kind].columns:
            values = getattr(received, column.attribute)
            np.testing.assert_array_equal(values, getattr(signal, column.attribute))
            assert values.flags.writeable


def test_every_cut_of_a_message_is_refused() -> None:
    whole = encode(made(MocapFrame, ("cf1", "cf2"), 0), 0)
    for length in range(len(whole)):
        with pytest.raises(BadMessageError):
            decode(whole[:length], MocapFrame)


def test_repeated_names_another_frame_and_unequal_arrays_are_refused_by_name() -> None:
    with pytest.raises(BadMessageError, match="duplicate vehicle names in cf1, cf1"):
        decode(encode(made(MocapFrame, ("cf1", "cf1"), 0), 0), MocapFrame)
    with pytest.raises(BadMessageError, match="frame_id 'wOrld'"):
        decode(encode(made(MocapFrame, ("cf1",), 0), 0).replace(b"world", b"wOrld"), MocapFrame)
    with pytest.raises(BadMessageError, match="frame_id 'body'; must be 'world'"):
        decode(encode(made(MocapFrame, ("cf1",), 0), 0).replace(b"world", b"body\0"), MocapFrame)
    whole = encode(made(MocapFrame, ("cf1", "cf2"), 0), 0)
    count = np.uint32(6).tobytes()
    assert whole.count(count) == 2  # the length of "world" with its zero, and of position
    head, _, numbers = whole.rpartition(count)
    with pytest.raises(BadMessageError, match="position has 3 numbers; 2 names need 6"):
        decode(head + np.uint32(3).tobytes() + numbers, MocapFrame)
    with pytest.raises(BadMessageError, match="MocapFrame makes 148 bytes; 2 names need 172"):
        encode(MocapFrame(0.0, ("cf1", "cf2"), np.zeros((1, 3)), np.zeros((2, 4))), 0)


@given(STAMPS)
def test_a_clock_is_a_stamp_and_nothing_else(stamp_ns: int) -> None:
    clock = STORE.deserialize_cdr(encode_stamp(stamp_ns), "rosgraph_msgs/msg/Clock").clock
    assert (clock.sec, clock.nanosec) == divmod(stamp_ns, 10**9)
