"""The 95 % intervals of an explanation hold what they are of, with few orders and few seeds."""

import numpy as np
import pytest

from q2q_sim.experiments.explanation.explanation import half_widths_of_shares
from q2q_sim.experiments.explanation.shapley import orders_of, shapley_shares


@pytest.mark.parametrize("orders", [4, 8])
@pytest.mark.parametrize("alike", [0.0, 0.9])
def test_an_interval_of_random_orders_holds_the_share_in_95_percent_or_more(
    orders: int, alike: float
) -> None:
    """Whether the shares in an order and in its reverse are independent or nearly the same."""
    rng = np.random.default_rng(1)
    pair, each = rng.normal(size=(2, 1, orders, 20000))  # each cause a draw; the share is 0
    found = np.sqrt(alike) * np.repeat(pair[:, ::2], 2, axis=1) + np.sqrt(1.0 - alike) * each
    held = np.abs(found[0].mean(axis=0)) <= half_widths_of_shares(found, exact=False)
    assert 0.944 <= held.mean() <= 0.99  # four standard errors of 20000 draws below 0.95


def test_an_interval_of_reversed_orders_holds_the_share_of_all_orders() -> None:
    causes, rng, held = list("abcdef"), np.random.default_rng(3), []
    together = np.isin(causes, list("abc"))  # they only act together: a third each
    for _ in range(200):
        found = shapley_shares(causes, orders_of(causes, 8, rng), lambda out: float(not out & set("abc")))
        held.append(
            np.abs(found.mean(axis=0) - together / 3)
            <= half_widths_of_shares(found[None], exact=False) + 1e-12
        )
    assert np.mean(held) >= 0.95


@pytest.mark.parametrize("seeds", [2, 3, 8])
def test_an_interval_of_seeds_holds_the_share_with_another_seed_in_95_percent(seeds: int) -> None:
    share = np.random.default_rng(2).normal(size=(seeds + 1, 1, 20000))
    held = np.abs(share[-1, 0] - share[0, 0]) <= half_widths_of_shares(share[:-1], exact=True)
    assert 0.95 <= held.mean() <= 0.97  # above 0.95: the own share is one of those that give the spread
