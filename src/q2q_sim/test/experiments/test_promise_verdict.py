"""A verdict counts what happened, with the bound of each rate."""

import json
from dataclasses import replace

import numpy as np
import pytest
from blank_encounters import BLANK, CONDITIONS

from q2q_model.documents.json_file import with_nulls
from q2q_sim.experiments.promise.promise_verdict import Rate, promise_verdict, verdict_json
from q2q_sim.experiments.promise.tracking_tube import (
    learn_tube,
)


def test_the_bound_of_a_rate_is_that_of_clopper_and_pearson() -> None:
    """Without events 1 - 0.05^(1/n); with k events the rate at which k or fewer come in 5 % of all cases."""
    assert Rate(0, 100).most == pytest.approx(1.0 - 0.05**0.01)
    most = Rate(1, 50).most
    assert (1.0 - most) ** 50 + 50 * most * (1.0 - most) ** 49 == pytest.approx(0.05)
    assert Rate(3, 3).most == 1.0


def test_a_verdict_counts_what_happened_under_the_conditions_apart_from_the_rest() -> None:
    kept = replace(BLANK, seed=1, vehicles=3, arrived=True, in_reach=True)
    left = replace(kept, seed=0, horizontal=0.5, broken_ticks=7, arrived=False)
    entered = replace(kept, seed=2, clearance=-0.01, announced=False, arrived=None, in_reach=None)
    other = replace(entered, seed=3, apart_at_start=False, announced=True, horizontal=9.0)
    tube = learn_tube(np.full((19 * 5 // 4 + 1, 2), 0.1), 0.05, CONDITIONS)
    found = promise_verdict([kept, left, entered, other], tube)
    assert verdict_json(found) == {
        "flights": 4, "vehicles": 12, "under_conditions": 3, "entries_under_conditions": 1,
        "entry_rate_most": Rate(1, 3).most, "entries_otherwise": 1, "entries_not_announced": 1,
        "least_distance_m": -0.01, "ticks": 300, "broken_ticks": 7, "left_tube": 1,
        "left_tube_rate_most": Rate(1, 3).most, "arrived": 1, "can_arrive": 2,
        "in_reach": 2,
    }  # fmt: skip


def test_the_numbers_of_flights_none_of_which_counts_are_json() -> None:
    found = with_nulls(verdict_json(promise_verdict([], None)))
    assert isinstance(found, dict)
    assert found["least_distance_m"] is None  # of no vehicles
    json.dumps(found, allow_nan=False)
