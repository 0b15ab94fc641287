"""Outcomes of campaign runs that are made up."""

from q2q_sim.experiments.campaign.run_outcome import (
    RunOutcome,
)
from q2q_sim.monitors.policies import Violation

BROKEN = Violation("tilt", "cf1", 1.0, 0.5, 0.36)


def ended(seed: int, *violations: Violation) -> RunOutcome:
    """Return the outcome of a run of 2 s."""
    return RunOutcome(seed, through_nodes=False, what="made up", violations=violations, seconds=2.0)
