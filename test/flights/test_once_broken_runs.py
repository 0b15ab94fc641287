"""Runs in which a policy was violated once violate none."""

from pathlib import Path

import pytest

from q2q_sim.campaigns.random_runs import campaign_flight
from q2q_sim.campaigns.random_runs.random_run import draw_run
from q2q_sim.campaigns.random_runs.through_nodes import NodeFlights

ONCE_BROKEN = (
    15, 226, 237, 261, 298, 354, 363, 382, 450, 542, 552,
    565, 721, 736, 790, 836, 850, 1174, 1514, 1517, 1978,
)  # fmt: skip
"""Seeds that a policy was violated in, each by a cause of its own: docs/findings.md has them."""


@pytest.mark.parametrize("seed", ONCE_BROKEN)
def test_what_once_violated_a_policy_violates_none(seed: int) -> None:
    assert campaign_flight.fly_pure(draw_run(seed)).violations == ()


@pytest.mark.parametrize("seed", [20, 44])
def test_what_once_violated_a_policy_through_the_nodes_violates_none(seed: int, tmp_path: Path) -> None:
    with NodeFlights(tmp_path / "nodes", tmp_path / "kept") as flights:
        assert flights.fly_and_judge(seed).violations == ()
