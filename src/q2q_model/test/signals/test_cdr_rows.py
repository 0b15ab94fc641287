"""Tests of rows read all at once against the messages read one by one."""

import numpy as np
import pytest
from bag_signals import STEP_NS, random_signal
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_model.signals.cdr.cdr_format import NAMES_AT, STAMP, START, BadMessageError
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.cdr.cdr_rows import MOST_KINDS, rows_of_messages
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.layout import LAYOUTS, Signal
from q2q_model.signals.rows import SignalRows
from q2q_model.signals.values import MocapFrame, SwarmState

SWARMS = (("cf1", "cf2"), ("cf2", "cf1"), ("cf1",), (), ("cf1", "cf2", "cf3"))


def recorded(kind: type[Signal], swarms: list[tuple[str, ...]]) -> list[bytes]:
    """Return one message a tick with these names."""
    rng = np.random.default_rng(len(swarms))
    return [
        encode(random_signal(kind, tick, names, rng), tick * STEP_NS) for tick, names in enumerate(swarms)
    ]


def assert_same_as_one_by_one(found: list[SignalRows], messages: list[bytes], kind: type[Signal]) -> None:
    """Compare every number of every row with the message it came from."""
    places = np.concatenate([rows.place for rows in found])
    np.testing.assert_array_equal(np.sort(places), np.arange(len(messages)))
    for rows in found:
        for row, place in enumerate(rows.place):
            one = decode(messages[place], kind)
            assert rows.names == one.names
            assert rows.t[row] == one.t
            for column in LAYOUTS[kind].columns:
                np.testing.assert_array_equal(
                    rows.values[column.attribute][row], getattr(one, column.attribute)
                )


@given(st.sampled_from(list(LAYOUTS)), st.lists(st.sampled_from(SWARMS), min_size=1, max_size=30))
@settings(max_examples=60, deadline=None)
def test_rows_of_any_recording_are_its_messages(kind: type[Signal], swarms: list[tuple[str, ...]]):
    messages = recorded(kind, swarms)
    assert_same_as_one_by_one(rows_of_messages(messages, kind), messages, kind)


def test_more_kinds_of_one_length_than_are_looked_for_are_read_too():
    swarms = [(f"cf{k}",) for k in range(MOST_KINDS + 2) for _ in range(2)]
    messages = recorded(SwarmState, swarms)
    assert_same_as_one_by_one(rows_of_messages(messages, SwarmState), messages, SwarmState)


def test_no_message_gives_no_rows():
    assert rows_of_messages([], MocapFrame) == []


def test_padding_that_differs_changes_no_number():
    messages = recorded(MocapFrame, [("cf1", "cf2")] * 4)
    at = messages[0].index(b"world\0") + 6  # names begin at a multiple of four: two bytes of padding
    messages[2] = messages[2][:at] + b"\xaa\xbb" + messages[2][at + 2 :]
    assert_same_as_one_by_one(rows_of_messages(messages, MocapFrame), messages, MocapFrame)


def test_one_bad_message_among_good_ones_is_refused():
    messages = recorded(MocapFrame, [("cf1", "cf2")] * 4)
    at = messages[0].index(b"cf2\0")
    messages[2] = messages[2][:at] + b"cf1\0" + messages[2][at + 4 :]
    with pytest.raises(BadMessageError, match="duplicate vehicle names"):
        rows_of_messages(messages, MocapFrame)


@pytest.mark.parametrize("stamp", [(5, 2_000_000_000), (2**31 - 1, 0)])
def test_one_stamp_out_of_its_range_among_good_ones_is_refused(stamp: tuple[int, int]) -> None:
    messages = recorded(MocapFrame, [("cf1", "cf2")] * 4)
    messages[2] = messages[2][:START] + STAMP.pack(*stamp) + messages[2][NAMES_AT:]
    with pytest.raises(BadMessageError, match=f"stamp of sec {stamp[0]}, nanosec {stamp[1]}"):
        rows_of_messages(messages, MocapFrame)
