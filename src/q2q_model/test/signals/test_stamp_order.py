"""Wrong stamps, and clocks that are set back."""

import pytest

from q2q_model.signals.repeated_stamp import StampOrder


def late_ones(stamps: list[float]) -> list[float]:
    """Return the stamps that are late."""
    order = StampOrder()
    return [t for t in stamps if order.reject_stamp(t)]


def test_a_tick_older_than_one_before_is_rejected_and_newer_or_equal_ones_are_not() -> None:
    assert late_ones([1.0, 1.01, 1.01, 0.7, 1.02, 1.01, 1.03]) == [0.7, 1.01]


def test_old_stamps_that_rise_for_a_tenth_of_a_second_are_a_clock_set_back() -> None:
    old = [0.5 + 0.01 * k for k in range(20)]
    assert late_ones([1.0, *old]) == pytest.approx(old[:10])


@pytest.mark.parametrize("off", [-1e9, -7.0, 3.0, 1e9])
def test_one_stamp_far_off_is_rejected_however_far_it_is(off: float) -> None:
    assert late_ones([10.0, 10.0 + off, 10.01, 10.02]) == [10.0 + off]


def test_stamps_far_ahead_are_late_until_they_have_risen_for_a_tenth_of_a_second() -> None:
    assert late_ones([1.0, 5.0, 5.0, 4.9, 4.99, 5.0, 5.01]) == [5.0, 5.0, 4.9, 4.99]


def test_stamps_that_go_on_from_before_are_no_clock_set_back() -> None:
    ahead = [7.0 + 0.01 * k for k in range(10)]
    assert late_ones([1.0, *ahead, 1.11, 1.12]) == ahead


def test_a_clock_is_set_back_to_the_first_of_its_old_stamps() -> None:
    """The time for which they rise until it is known has passed."""
    order, set_back = StampOrder(), []
    for t in (1.0, 0.7, 1.01, *(0.5 + 0.01 * k for k in range(20)), 1.6, *(0.1 * k - 4.0 for k in range(9))):
        order.reject_stamp(t)
        set_back.append(order.set_back)
    assert {k: by for k, by in enumerate(set_back) if by} == pytest.approx({13: 0.51, 26: 5.6})


def test_after_a_reset_no_tick_is_rejected() -> None:
    order = StampOrder()
    assert not order.reject_stamp(1.0)
    order.reset()
    assert not order.reject_stamp(0.5)
