"""Draws of flights with replacement."""

import numpy as np

from q2q_model.identification.statistics.flight_bootstrap import flight_draws


def test_every_flight_is_drawn_as_often_as_any_other():
    rows = flight_draws(4, 10_000)
    shares = np.bincount(rows.ravel(), minlength=4) / rows.size
    np.testing.assert_allclose(shares, 0.25, atol=0.01)  # 4.6 standard deviations of 40 000 draws
    assert rows.shape == (10_000, 4)


def test_draws_are_those_of_one_generator_call_by_call():
    """Intervals of recorded pages came from a call for each draw."""
    generator = np.random.default_rng(7)
    np.testing.assert_array_equal(
        flight_draws(5, 300, seed=7), [generator.integers(0, 5, 5) for _ in range(300)]
    )
