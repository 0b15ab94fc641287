"""Stamps, their parts and their times."""

from hypothesis import given
from hypothesis import strategies as st

from q2q_model.node.rehearsal import rehearsal
from q2q_model.signals.cdr import decode, encode
from q2q_model.signals.stamps import stamp_from_parts, stamp_from_time, stamp_parts, time_from_stamp
from q2q_model.signals.values import MocapFrame, SwarmState


@given(st.integers(0, 2**50))
def test_a_stamp_survives_its_parts_and_its_time(stamp_ns: int) -> None:
    assert stamp_from_parts(*stamp_parts(stamp_ns)) == stamp_ns
    assert stamp_from_time(time_from_stamp(stamp_ns)) == stamp_ns


def test_the_time_of_a_message_is_that_of_its_stamp_to_the_last_bit() -> None:
    """1.13 s is a stamp for which sec + nanosec * 1e-9 rounds to another float."""
    stamp_ns = 1_130_000_000
    assert time_from_stamp(stamp_ns) != 1 + 130_000_000 * 1e-9
    for kind in (MocapFrame, SwarmState):
        assert decode(encode(rehearsal(kind, 0.0), stamp_ns), kind).t == time_from_stamp(stamp_ns)
