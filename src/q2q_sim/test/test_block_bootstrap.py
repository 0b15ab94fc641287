"""Slopes of rows in blocks, where some or all rows have x = 0."""

import numpy as np
import pytest

from q2q_sim.air.learning.statistics.block_bootstrap import slope_spread


def test_rows_without_x_show_no_slope() -> None:
    assert slope_spread(np.zeros((40, 2)), np.repeat([0, 1], 20)) is None
    assert slope_spread(np.zeros((0, 2)), np.zeros(0, dtype=np.intp)) is None


def test_a_slope_that_one_block_shows_has_no_end_at_zero() -> None:
    """A quarter of the draws of two blocks takes the one with x = 0 twice: no slope, and not a slope of 0."""
    x = np.concatenate([np.zeros(20), np.linspace(0.1, 2.0, 20)])
    found = slope_spread(np.stack([x * 3.0 * x, x * x], axis=1), np.repeat([0, 1], 20))
    assert found is not None
    for end in (found.low, found.value, found.high):
        np.testing.assert_allclose(end, [3.0], rtol=1e-12)


def test_a_slope_in_noise_lies_in_its_interval() -> None:
    rng = np.random.default_rng(4)
    x = rng.standard_normal(4000)
    y = -0.7 * x + 0.5 * rng.standard_normal(x.size)
    found = slope_spread(np.stack([x * y, x * x], axis=1), np.repeat(np.arange(40), 100))
    assert found is not None
    assert found.low[0] < -0.7 < found.high[0]
    standard_error = 0.5 / np.sqrt(x.size)  # the interval is 3.92 of them wide
    assert found.high[0] - found.low[0] == pytest.approx(3.92 * standard_error, rel=0.3)  # of 200 draws
