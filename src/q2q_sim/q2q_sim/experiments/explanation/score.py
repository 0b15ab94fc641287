"""Score of the explanations: how often the first cause of an accident is named first."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from q2q_model.documents.json_file import Json
from q2q_sim.experiments.explanation.accidents import INJECTIONS, accident
from q2q_sim.experiments.explanation.explanation import ExplanationParams, explain

EFFORT = ExplanationParams(orders=4, draws=1)
"""Effort at which an explanation is scored: the order of the causes needs no intervals."""


@dataclass(frozen=True, slots=True)
class Answer:
    """First cause of an accident, and the cause that its explanation names first."""

    seed: int
    first: str
    named: str | None

    @property
    def right(self) -> bool:
        """Return whether they are the same."""
        return self.first == self.named


def answer_accidents(seeds: Sequence[int]) -> Iterator[Answer]:
    """Yield the answer to the accident of each seed."""
    for seed in seeds:
        given = accident(seed)
        yield Answer(seed, given.first, explain(given.setup, EFFORT).first)


def score_json(found: Sequence[Answer]) -> Json:
    """Return the totals of the answers: the contract of `explain --score --json`."""
    own = {cause: [one for one in found if one.first == cause] for cause in INJECTIONS}
    return {
        "accidents": len(found),
        "named_first": sum(one.right for one in found),
        "by_cause": {
            cause: {"accidents": len(some), "named_first": sum(one.right for one in some)}
            for cause, some in own.items()
        },
        "mistaken": [
            {"seed": one.seed, "first": one.first, "named": one.named} for one in found if not one.right
        ],
    }


def score_text(found: Sequence[Answer]) -> str:
    """Return the score in one line."""
    right = sum(one.right for one in found)
    return f"first cause named first in {right} of {len(found)} accidents ({right / len(found):.0%})"
