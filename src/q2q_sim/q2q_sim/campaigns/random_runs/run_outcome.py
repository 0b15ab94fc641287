"""Outcome of a run and totals of a campaign."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from q2q_sim.monitors.policies import POLICIES, Violation

CRASH = "crash"
"""Name, in addition to the policies, of a run that raised an error: the worst violation."""
MODE_AGREEMENT = "mode_agreement"
"""Name, in addition to the policies, of a run through the nodes that differs from closed_loop."""
NAMES = (*POLICIES, CRASH, MODE_AGREEMENT)
"""Names of what a run can violate."""
DIED = "died alone"
"""Description of a run whose process died, alone with it."""


@dataclass(frozen=True, slots=True)
class RunOutcome:
    """Outcome of a run."""

    seed: int
    through_nodes: bool
    what: str
    """Description of scenario, controller and faults."""
    violations: tuple[Violation, ...]
    seconds: float
    air: str = ""
    """Air named for the campaign; empty for that of the scenario."""

    @property
    def policies(self) -> list[str]:
        """Return the violated policies, once each."""
        return sorted({one.policy for one in self.violations})


def from_document(document: Mapping[str, object]) -> RunOutcome:
    """Return an outcome from plain values; raise ValueError if they are invalid."""
    try:
        violations = document["violations"]
        if not isinstance(violations, Sequence):
            raise ValueError(f"violations = {violations!r}; must be a list")  # noqa: TRY004  a bad document
        found = tuple(Violation(**one) for one in violations)
        if unknown := {one.policy for one in found} - {*NAMES}:
            raise ValueError(f"unknown policy {min(unknown)!r}; choose one of {', '.join(NAMES)}")
        return RunOutcome(
            seed=int(str(document["seed"])),
            through_nodes=bool(document["through_nodes"]),
            what=str(document["what"]),
            violations=found,
            seconds=float(str(document["seconds"])),
            air=str(document.get("air", "")),
        )
    except (KeyError, TypeError) as wrong:
        raise ValueError(f"not an outcome of a run: {wrong}") from wrong


def summary(outcomes: Sequence[RunOutcome], seconds: float) -> dict[str, object]:
    """Return the totals of a campaign: the contract of `campaign --json`."""
    counts = Counter(policy for one in outcomes for policy in one.policies)
    return {
        "runs": len(outcomes),
        "through_nodes": sum(one.through_nodes for one in outcomes),
        "violations": sum(bool(one.violations) for one in outcomes),
        "by_policy": {policy: counts[policy] for policy in NAMES},
        "seeds_of_violations": sorted({one.seed for one in outcomes if one.violations}),
        "seconds": seconds,
    }
