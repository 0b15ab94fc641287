"""Outputs that answer a tick again."""

import numpy as np

from q2q_model.signals.repeated_stamp import is_repeated
from q2q_model.signals.values import Interference

NAMES = ("a", "b")
LAST = Interference(1.25, NAMES, np.zeros((2, 3)), np.zeros((2, 3)), np.zeros(2, dtype=np.uint8))


def test_an_output_answers_its_own_stamp_for_its_own_vehicles_only() -> None:
    assert is_repeated(LAST, 1.25, NAMES)
    assert not is_repeated(LAST, np.nextafter(1.25, 2.0), NAMES)
    assert not is_repeated(LAST, 1.25, ("b", "a"))
    assert not is_repeated(None, 1.25, NAMES)
