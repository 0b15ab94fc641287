"""Outcomes of campaign runs that are made up, and campaigns in this process."""

import pytest

from q2q_sim.campaigns.random_runs.run_outcome import RunOutcome
from q2q_sim.monitors.policies import Violation
from q2q_sim.processes import parallel_work

BROKEN = Violation("tilt", "cf1", 1.0, 0.5, 0.36)


def ended(seed: int, *violations: Violation) -> RunOutcome:
    """Return the outcome of a run of 2 s."""
    return RunOutcome(seed, through_nodes=False, what="made up", violations=violations, seconds=2.0)


def run_in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let campaigns work in this process, where a test has replaced what they fly by."""
    monkeypatch.setattr(parallel_work, "_local", lambda work, numbers, *_: map(work, numbers))
