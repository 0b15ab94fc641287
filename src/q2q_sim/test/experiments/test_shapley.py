"""Shares of causes in a loss, over orders in which they are taken out."""

from math import factorial

import numpy as np
import pytest

from q2q_sim.experiments.explanation.causes import CAUSES
from q2q_sim.experiments.explanation.shapley import (
    all_orders_fit,
    half_widths_of_orders,
    orders_of,
    shapley_shares,
)

RNG = np.random.default_rng(0)


def test_shares_of_an_additive_loss_are_its_terms_in_every_order() -> None:
    sizes = {"a": 0.5, "b": 0.2, "c": -0.1, "d": 0.0}
    orders = orders_of(list(sizes), 4, RNG)
    found = shapley_shares(
        list(sizes), orders, lambda removed: sum(sizes.values()) - sum(map(sizes.get, removed))
    )
    np.testing.assert_allclose(found, [list(sizes.values())] * 4, atol=1e-12)
    np.testing.assert_allclose(half_widths_of_orders(found), 0.0, atol=1e-12)


def test_causes_that_only_act_together_share_alike() -> None:
    orders = orders_of(["a", "b", "c"], 6, RNG)
    assert len(set(orders)) == 6
    found = shapley_shares(["a", "b", "c"], orders, lambda removed: float(not removed & {"a", "b"}))
    np.testing.assert_allclose(found.mean(axis=0), [0.5, 0.5, 0.0])


@pytest.mark.parametrize(("causes", "fewest"), [(2, 4), (3, 4), (4, 6), (5, 8), (6, 14), (7, 22)])
def test_all_orders_are_taken_where_random_ones_may_need_as_many_flights(causes: int, fewest: int) -> None:
    """A flight is flown for each set of causes: 2^n, or two and n - 1 more for each order."""
    names = [str(k) for k in range(causes)]
    assert all_orders_fit(names, fewest)
    assert causes < 4 or not all_orders_fit(names, fewest - 2)
    assert len(orders_of(names, fewest, RNG)) == factorial(causes)


def test_a_flight_without_a_cause_has_one_order() -> None:
    assert orders_of([], 4, RNG) == [()]


def test_many_causes_are_taken_out_in_pairs_of_reversed_orders() -> None:
    orders = orders_of(list(CAUSES), 8, RNG)
    assert len(orders) == 8
    assert all(one == other[::-1] for one, other in zip(orders[::2], orders[1::2], strict=True))
