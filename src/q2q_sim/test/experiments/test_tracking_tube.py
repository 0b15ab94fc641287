"""A tube holds as often as it says, or is not learned."""

import numpy as np
import pytest
from blank_encounters import CONDITIONS

from q2q_sim.commands.promise import parser
from q2q_sim.experiments.promise.promise_flights import run
from q2q_sim.experiments.promise.tracking_tube import (
    conformal_bound,
    fewest_flights,
    learn_tube,
)


@pytest.mark.parametrize(("n", "alpha"), [(19, 0.05), (60, 0.05), (99, 0.01), (250, 0.01)])
def test_a_fresh_flight_leaves_the_bound_as_often_as_the_closed_form_says(n: int, alpha: float) -> None:
    """1 - k / (n + 1), for any continuous distribution; here one of heavy tails."""
    generator = np.random.default_rng(0)
    left = []
    for _ in range(4000):
        scores = generator.pareto(1.5, n)
        left.append((1.0 + conformal_bound(scores, alpha)) ** -1.5)  # exact, of a fresh draw
    rank = np.ceil((n + 1) * (1.0 - alpha) - 1e-9)
    expected = 1.0 - rank / (n + 1)
    # of Beta(n + 1 - k, k), over 4000 draws: five standard errors
    spread = np.sqrt(expected * (1.0 - expected) / (n + 2) / 4000)
    assert np.mean(left) == pytest.approx(expected, abs=5.0 * spread)
    assert np.mean(left) <= 1.2 * alpha


@pytest.mark.parametrize("alpha", [0.05, 0.01])
def test_a_tube_of_both_errors_is_left_by_no_more_than_its_share_of_fresh_flights(alpha: float) -> None:
    generator = np.random.default_rng(1)
    left = []
    for _ in range(300):
        # heights err less than positions, and both err together
        errors = generator.gamma(4.0, 0.02, (1400, 1)) * generator.gamma(3.0, [1.0, 0.4], (1400, 2))
        tube = learn_tube(errors[:400], alpha, CONDITIONS)
        left.append(np.mean([not tube.holds(one) for one in errors[400:]]))
    assert alpha / 1.2 < np.mean(left) <= 1.2 * alpha


def test_the_fewest_flights_bound_by_their_largest_error() -> None:
    assert fewest_flights(0.05) == 19
    assert fewest_flights(0.01) == 99
    assert conformal_bound(np.arange(19.0), 0.05) == 18.0
    assert conformal_bound(np.arange(99.0), 0.05) == 94.0  # the 95th of 99
    with pytest.raises(ValueError, match=r"18 scores at alpha = 0.05; must be at least 19"):
        conformal_bound(np.arange(18.0), 0.05)


@pytest.mark.parametrize(("alpha", "fewest"), [(0.05, 24), (0.01, 124)])
def test_too_few_flights_for_a_tube_are_refused_before_they_are_flown(alpha: float, fewest: int) -> None:
    learn_tube(np.random.default_rng(3).random((fewest, 2)), alpha, CONDITIONS)
    asked = ["--count", str(fewest - 1), "--alpha", str(alpha), "--learn", "tube.json"]
    with pytest.raises(ValueError, match=rf"{fewest - 1} flights at alpha = {alpha:g}: .* at least"):
        run(parser().parse_args(asked))


@pytest.mark.parametrize(("row", "error"), [(0, np.nan), (-1, np.nan), (-1, np.inf), (slice(None), 0.0)])
def test_errors_that_give_no_tube_are_refused(row: int | slice, error: float) -> None:
    errors = np.random.default_rng(3).random((24, 2))
    errors[row, 1] = error
    with pytest.raises(ValueError, match="must all be finite and mostly above 0"):
        learn_tube(errors, 0.05, CONDITIONS)
