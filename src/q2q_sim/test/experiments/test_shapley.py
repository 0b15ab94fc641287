"""Shares of causes in a loss, over orders in which they are taken out."""

import numpy as np

from q2q_sim.experiments.explanation.causes import CAUSES
from q2q_sim.experiments.explanation.shapley import orders_of, shapley_shares, standard_error

RNG = np.random.default_rng(0)


def test_shares_of_an_additive_loss_are_its_terms_in_every_order() -> None:
    sizes = {"a": 0.5, "b": 0.2, "c": -0.1, "d": 0.0}
    orders = orders_of(list(sizes), 6, RNG)
    found = shapley_shares(
        list(sizes), orders, lambda removed: sum(sizes.values()) - sum(map(sizes.get, removed))
    )
    np.testing.assert_allclose(found, [list(sizes.values())] * 6, atol=1e-12)
    np.testing.assert_allclose(standard_error(found), 0.0, atol=1e-12)


def test_causes_that_only_act_together_share_alike() -> None:
    orders = orders_of(["a", "b", "c"], 6, RNG)
    assert len(set(orders)) == 6
    found = shapley_shares(["a", "b", "c"], orders, lambda removed: float(not removed & {"a", "b"}))
    np.testing.assert_allclose(found.mean(axis=0), [0.5, 0.5, 0.0])


def test_many_causes_are_taken_out_in_pairs_of_reversed_orders() -> None:
    orders = orders_of(list(CAUSES), 8, RNG)
    assert len(orders) == 8
    assert all(one == other[::-1] for one, other in zip(orders[::2], orders[1::2], strict=True))
