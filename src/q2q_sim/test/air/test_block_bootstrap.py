"""Intervals of means of blocks, and of slopes of rows in blocks, where some or all rows have x = 0."""

import numpy as np
import pytest

from q2q_model.signals.values import Array
from q2q_sim.air.learning.statistics.block_bootstrap import (
    Row,
    Spread,
    block_of_rows,
    estimate_spread,
    slope_spread,
)


def test_rows_without_x_show_no_slope() -> None:
    assert slope_spread(np.zeros((40, 2)), np.repeat([0, 1], 20)) is None
    assert slope_spread(np.zeros((0, 2)), np.zeros(0, dtype=np.intp)) is None


@pytest.mark.parametrize("shown", [1, 2])
def test_a_slope_that_one_or_two_blocks_show_has_no_interval(shown: int) -> None:
    """Too little is known of how it differs between blocks, however many others have x = 0."""
    x = np.concatenate([np.zeros(40), *[np.linspace(0.1, 2.0, 20)] * shown])
    found = slope_spread(np.stack([x * 3.0 * x, x * x], axis=1), np.repeat(np.arange(2 + shown), 20))
    assert found is not None
    np.testing.assert_allclose(found.value, [3.0], rtol=1e-12)
    assert np.isnan([found.low[0], found.high[0]]).all()


def test_blocks_without_x_change_no_interval() -> None:
    x = np.linspace(0.1, 2.0, 60)
    products = np.stack([x * (3.0 + np.sin(9.0 * x)) * x, x * x], axis=1)
    shown = slope_spread(products, np.repeat([0, 1, 2], 20))
    found = slope_spread(np.concatenate([np.zeros((40, 2)), products]), np.repeat([0, 1, 2, 3, 4], 20))
    assert shown is not None
    assert found is not None
    assert (found.low, found.value, found.high) == (shown.low, shown.value, shown.high)
    assert found.low[0] < found.value[0] < found.high[0]


def test_a_slope_in_noise_lies_in_its_interval() -> None:
    rng = np.random.default_rng(4)
    x = rng.standard_normal(4000)
    y = -0.7 * x + 0.5 * rng.standard_normal(x.size)
    found = slope_spread(np.stack([x * y, x * x], axis=1), np.repeat(np.arange(40), 100))
    assert found is not None
    assert found.low[0] < -0.7 < found.high[0]
    standard_error = 0.5 / np.sqrt(x.size)  # the interval is 3.92 of them wide
    assert found.high[0] - found.low[0] == pytest.approx(3.92 * standard_error, rel=0.3)  # of 200 draws


@pytest.mark.parametrize("blocks", [6, 12])
def test_an_interval_of_few_blocks_holds_the_mean_in_nearly_95_percent(blocks: int) -> None:
    rng, held = np.random.default_rng(5), []
    for _ in range(200):
        found = _spread_of_mean(0.3 + 0.16 * rng.standard_normal(blocks))
        held.append(found.low[0] <= 0.3 <= found.high[0])
    assert np.mean(held) >= 0.9


def _spread_of_mean(each: Array) -> Spread:
    def mean(weight: Array) -> Array:
        return np.array([float(weight @ each / weight.sum())])

    return estimate_spread(mean, each.size)


def test_stretches_are_the_same_whatever_the_epoch_of_a_flights_clock() -> None:
    t = 0.7 + 0.01 * np.arange(1000)
    first = block_of_rows([Row("a", t), Row("b", t), Row("a", t[300:])])
    later = block_of_rows([Row("a", t + 1.7e9), Row("b", t + 5.3), Row("a", t[300:] + 1.7e9)])
    np.testing.assert_array_equal(first, later)
    np.testing.assert_array_equal(first[:1000], np.arange(1000) // 200)
    np.testing.assert_array_equal(first[2000:], first[300:1000])  # vehicles of a flight stay together
