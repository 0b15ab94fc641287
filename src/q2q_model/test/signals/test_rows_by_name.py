"""Rows of an array follow their vehicles by name."""

import numpy as np
import pytest

from q2q_model.signals.values import Array, Names, rows_by_name

PAIR: Names = ("cf1", "cf2")
POS = np.array([[1.0, 2.0], [3.0, 4.0]])


@pytest.mark.parametrize(
    ("missing", "expected"),
    [(0.0, [0.0, 0.0]), (np.nan, [np.nan, np.nan]), (np.array([7.0, 8.0]), [7.0, 8.0]),
     (np.arange(6.0).reshape(3, 2), [2.0, 3.0])],
)  # fmt: skip
def test_who_is_absent_gets_a_number_a_row_or_its_own_row(
    missing: float | Array, expected: list[float]
) -> None:
    found = rows_by_name(POS, PAIR, ("cf2", "cf3", "cf1"), missing)
    np.testing.assert_array_equal(found, [[3.0, 4.0], expected, [1.0, 2.0]])


def test_of_nobody_all_rows_are_missing_and_the_type_is_kept() -> None:
    found = rows_by_name(np.zeros(0, np.uint8), (), PAIR, 2)
    assert (found.tolist(), found.dtype) == ([2, 2], np.uint8)
    assert rows_by_name(POS, PAIR, ()).shape == (0, 2)


def test_the_rows_are_a_copy() -> None:
    found = rows_by_name(POS, PAIR, PAIR)
    found[0] = 9.0
    assert POS[0, 0] == 1.0
