"""The 95 % intervals of what differs between flights of vehicles hold it, with few vehicles too."""

from itertools import product

import numpy as np
import pytest
from scipy.special import stdtrit

from q2q_model.signals.values import Array
from q2q_sim.air.learning.statistics.block_bootstrap import Spread
from q2q_sim.air.learning.statistics.vehicle_spread import (
    deviation_of_draws,
    mean_spread,
    median_spread,
)

MEAN, DEVIATION = 0.3, 0.16


@pytest.mark.parametrize("vehicles", [3, 6, 38])
def test_an_interval_holds_mean_and_deviation_of_vehicles_in_95_percent(vehicles: int) -> None:
    rng, held = np.random.default_rng(1), []
    for _ in range(1000):
        each = MEAN + DEVIATION * rng.standard_normal(vehicles)
        mean, deviation = mean_spread(each), deviation_of_draws(each)
        held.append([mean.low <= MEAN <= mean.high, deviation.low <= DEVIATION <= deviation.high])
    np.testing.assert_allclose(np.mean(held, axis=0).ravel(), 0.95, atol=0.028)  # four standard errors


@pytest.mark.parametrize("own", [0.05, 0.16])
def test_an_interval_holds_the_deviation_beyond_the_vehicles_own_errors(own: float) -> None:
    rng, held = np.random.default_rng(2), []
    for _ in range(1000):
        errors = own * rng.uniform(0.5, 1.5, 6)
        each = DEVIATION * rng.standard_normal(6) + errors * rng.standard_normal(6)
        found = deviation_of_draws(each, float((errors**2).mean()))
        held.append(found.low[0] <= DEVIATION <= found.high[0])
    assert 0.92 <= np.mean(held) <= 0.98  # errors that differ make it approximate


@pytest.mark.parametrize("vehicles", [3, 12])
def test_an_interval_holds_the_median_of_vehicles_in_nearly_95_percent_or_more(vehicles: int) -> None:
    rng, held = np.random.default_rng(3), []
    for _ in range(200):
        found = _spread_of_median(MEAN + DEVIATION * rng.standard_normal(vehicles))
        held.append(found.low[0] <= MEAN <= found.high[0])
    assert np.mean(held) >= 0.9  # three standard errors below 0.95


def _spread_of_median(each: Array, least: float = -np.inf) -> Spread:
    return median_spread(each[:, None], least)


def test_the_error_of_a_median_is_that_over_all_bootstrap_draws_in_any_order() -> None:
    each = np.array([0.07, 0.15, 10.0, 0.31, 0.79])
    draws = np.array([np.median(one) for one in product(each, repeat=each.size)])
    wide = stdtrit(4, 0.975) * draws.std() * np.sqrt(5 / 4)
    for ordered in (each, each[::-1]):
        found = _spread_of_median(ordered)
        np.testing.assert_allclose(found.value, 0.31)
        np.testing.assert_allclose(found.high - found.value, wide, rtol=1e-9)


def test_a_median_below_its_least_value_is_that_value_with_an_interval_of_nothing() -> None:
    found = _spread_of_median(np.array([-3.0, -2.9, -3.1, -3.0]), 0.0)
    assert [float(one[0]) for one in (found.value, found.low, found.high)] == [0.0, 0.0, 0.0]


def test_two_vehicles_give_values_without_intervals() -> None:
    each = np.array([0.2, 0.4])
    median = _spread_of_median(each)
    for found, value in ((mean_spread(each), 0.3), (deviation_of_draws(each), np.sqrt(0.02)), (median, 0.3)):
        np.testing.assert_allclose(found.value, value)
        assert np.isnan([found.low, found.high]).all()


def test_an_interval_ends_at_the_least_value() -> None:
    each = np.array([0.0, 0.01, 0.5, 0.02])
    found = _spread_of_median(each, 0.0)
    assert found.low[0] == 0.0
    assert found.high[0] > 0.015
