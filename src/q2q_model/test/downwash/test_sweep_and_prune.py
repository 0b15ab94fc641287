"""The sweep finds the pairs that a comparison of all finds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from q2q_model.downwash.interaction_model import Reach
from q2q_model.downwash.sweep_and_prune import pairs_in_reach
from q2q_model.signals.values import Array

coordinate = st.one_of(st.floats(-2.0, 2.0), st.just(np.nan), st.sampled_from([0.0, 0.5]))


@settings(deadline=None)  # the first call compiles
@given(hnp.arrays(np.float64, st.tuples(st.integers(0, 12), st.just(3)), elements=coordinate))
def test_the_sweep_finds_exactly_the_pairs_of_the_dense_twin(pos: np.ndarray):
    reach = Reach(horizontal=0.8, vertical=1.0)
    for found, expected in zip(pairs_in_reach(pos, reach), _dense(pos, reach), strict=True):
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("n", [2, 40, 300])
def test_a_dense_crowd_outgrows_the_first_buffer_and_still_agrees(n: int):
    pos = np.random.default_rng(3).normal(size=(n, 3))
    reach = Reach(horizontal=2.0, vertical=2.0)
    for found, expected in zip(pairs_in_reach(pos, reach), _dense(pos, reach), strict=True):
        np.testing.assert_array_equal(found, expected)


def test_vehicles_in_the_same_place_are_a_pair_both_ways():
    i, j = pairs_in_reach(np.zeros((2, 3)), Reach(horizontal=0.1, vertical=0.1))
    assert [tuple(pair) for pair in np.stack([i, j], axis=1)] == [(0, 1), (1, 0)]


def test_the_sweep_compares_near_rows_only():
    """In a line with one neighbour within reach, pairs grow as n, not n^2."""
    n = 1000
    line = np.stack([np.arange(n) * 1.0, np.zeros(n), np.zeros(n)], axis=1)
    i, j = pairs_in_reach(line[::-1], Reach(horizontal=1.5, vertical=1.0))
    assert i.size == 2 * (n - 1)
    np.testing.assert_array_equal(np.abs(i - j), 1)


def _dense(pos: Array, reach: Reach) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the pairs by comparing all."""
    rel = pos[None, :, :] - pos[:, None, :]  # (n, n, 3)
    near = rel[..., 0] ** 2 + rel[..., 1] ** 2 <= reach.horizontal**2
    near &= np.abs(rel[..., 2]) <= reach.vertical
    np.fill_diagonal(near, val=False)
    i, j = np.nonzero(near)
    return i, j
