"""The last tick at which a mask was true, and its runs of True, against a loop over the ticks."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from q2q_model.flights.masks_over_time import last_row, last_time, runs_of_true
from q2q_model.signals.values import Array, Mask

MASKS = hnp.arrays(np.bool_, hnp.array_shapes(min_dims=1, max_dims=2, min_side=0, max_side=7))


@given(MASKS)
def test_last_row_is_that_of_the_newest_true_up_to_each(mask: Mask) -> None:
    found, one = last_row(mask), np.full(mask.shape[1:], -1)
    assert found.shape == mask.shape
    for row, now in enumerate(mask):
        one = np.where(now, row, one)
        np.testing.assert_array_equal(found[row], one)


@given(MASKS)
def test_last_time_is_that_of_the_last_row(mask: Mask) -> None:
    t: Array = np.linspace(5.0, 6.0, len(mask))
    row = last_row(mask)
    expected = np.where(row < 0, -np.inf, np.append(t, np.nan)[row])
    np.testing.assert_array_equal(last_time(mask, t), expected)


def test_where_time_steps_back_the_latest_counts() -> None:
    t = np.array([0.0, 5.0, 1.0, 2.0])
    found = last_time(np.array([False, True, True, False]), t)
    np.testing.assert_array_equal(found, [-np.inf, 5.0, 5.0, 5.0])


@given(st.lists(st.booleans(), max_size=12))
def test_runs_cover_exactly_the_true_rows_and_never_touch(rows: list[bool]) -> None:
    runs = runs_of_true(np.array(rows, dtype=np.bool_))
    covered = [row for begin, end in runs for row in range(begin, end)]
    assert covered == [row for row, true in enumerate(rows) if true]
    assert all(end < begin for (_, end), (begin, _) in pairwise(runs))
