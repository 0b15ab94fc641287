"""Stamps, their parts and their times."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.cdr.cdr_format import BadMessageError, header_stamp_ns
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.stamps import (
    END_S,
    BadStampError,
    stamp_from_parts,
    stamp_from_time,
    stamp_parts,
    time_from_stamp,
)
from q2q_model.signals.values import MocapFrame, SwarmState


@given(st.integers(0, 2**50))
def test_a_stamp_survives_its_parts_and_its_time(stamp_ns: int) -> None:
    assert stamp_from_parts(*stamp_parts(stamp_ns)) == stamp_ns
    assert stamp_from_time(time_from_stamp(stamp_ns)) == stamp_ns


@pytest.mark.parametrize("parts", [(1, 10**9), (2**31 - 1, 2**32 - 1), (-(2**31), 0), (END_S, 0)])
def test_a_stamp_that_is_none_or_too_close_to_the_end_to_be_answered_is_refused(
    parts: tuple[int, int],
) -> None:
    with pytest.raises(BadStampError, match=rf"stamp of sec {parts[0]}, nanosec {parts[1]}; sec must be"):
        stamp_from_parts(*parts)
    data = encode(synthetic_signal(MocapFrame, 0.0), 0)
    spoiled = data[:4] + struct.pack("<iI", *parts) + data[12:]
    for read in (header_stamp_ns, lambda data: decode(data, MocapFrame)):
        with pytest.raises(BadMessageError, match="nanosec"):
            read(spoiled)


def test_the_time_of_a_message_is_that_of_its_stamp_to_the_last_bit() -> None:
    """1.13 s is a stamp for which sec + nanosec * 1e-9 rounds to another float."""
    stamp_ns = 1_130_000_000
    assert time_from_stamp(stamp_ns) != 1 + 130_000_000 * 1e-9
    for kind in (MocapFrame, SwarmState):
        assert decode(encode(synthetic_signal(kind, 0.0), stamp_ns), kind).t == time_from_stamp(stamp_ns)
