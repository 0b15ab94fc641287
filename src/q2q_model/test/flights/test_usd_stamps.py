"""Stamps of a micro-SD log that repeat, are swapped or damaged cost only what cannot be a row of its own."""

import numpy as np
import pytest

from q2q_model.flights.tables.usd_stamps import rising_rows

PLAIN = np.arange(230.0)


@pytest.mark.parametrize("each", [2, 3])
def test_of_equal_stamps_the_first_row_is_kept(each: int) -> None:
    np.testing.assert_array_equal(rising_rows(np.repeat(PLAIN, each)), each * np.arange(PLAIN.size))


def test_a_repeated_stamp_costs_one_row() -> None:
    np.testing.assert_array_equal(rising_rows(np.insert(PLAIN, 50, 50.0)), np.delete(np.arange(231), 51))


@pytest.mark.parametrize("first", [0, 1, 50, PLAIN.size - 2])
def test_of_two_rows_that_are_swapped_one_is_kept(first: int) -> None:
    t = PLAIN.copy()
    t[[first, first + 1]] = t[[first + 1, first]]
    rows = rising_rows(t)
    assert len(rows) == PLAIN.size - 1
    assert (np.diff(t[rows]) > 0.0).all()


@pytest.mark.parametrize("row", [0, 1, 2, 50, 51, 459])
@pytest.mark.parametrize("damage", [2.0**10, 2.0**40])
def test_a_damaged_stamp_among_pairs_of_equal_ones_costs_no_time(row: int, damage: float) -> None:
    t = np.repeat(PLAIN, 2)
    t[row] += damage
    np.testing.assert_array_equal(t[rising_rows(t)], PLAIN)


def test_stamps_of_whole_milliseconds_at_1_khz_with_jitter_keep_nearly_one_row_for_each() -> None:
    rng = np.random.default_rng(0)
    t = np.floor(np.arange(230) + rng.uniform(-0.6, 0.6, 230))
    kept = t[rising_rows(t)]
    assert (np.diff(kept) > 0.0).all()
    assert len(kept) >= 0.95 * len(np.unique(t))
