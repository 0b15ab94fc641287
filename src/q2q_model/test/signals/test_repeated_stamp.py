"""Outputs that answer a tick again, and stamps under which nothing is remembered."""

import numpy as np

from q2q_model.signals.repeated_stamp import StampOrder, is_repeated
from q2q_model.signals.values import Interference

NAMES = ("a", "b")
LAST = Interference(1.25, NAMES, np.zeros((2, 3)), np.zeros((2, 3)), np.zeros(2, dtype=np.uint8))


def test_an_output_answers_its_own_stamp_for_its_own_vehicles_only() -> None:
    assert is_repeated(LAST, 1.25, NAMES)
    assert not is_repeated(LAST, np.nextafter(1.25, 2.0), NAMES)
    assert not is_repeated(LAST, 1.25, ("b", "a"))
    assert not is_repeated(None, 1.25, NAMES)


def test_a_late_stamp_and_one_far_ahead_are_wrong_until_their_clock_goes_on_for_a_tenth_of_a_second() -> None:
    order, ahead, back = StampOrder(), [9.0, 9.05, 9.1], [1.0, 1.04, 1.08, 1.12]
    stamps = [2.0, 2.01, 1.99, 5.0, 2.02, 2.02, *ahead, 9.11, *back, 1.13]
    seen = [(t, order.reject_stamp(t), order.was_set) for t in stamps]
    assert [t for t, rejected, _ in seen if rejected] == [1.99, 5.0, *ahead[:-1], *back[:-1]]
    assert [t for t, _, was_set in seen if was_set] == [ahead[-1], back[-1]]
