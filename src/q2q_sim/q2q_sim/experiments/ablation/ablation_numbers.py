"""Numbers of the ablation in a file, saved after each flight, so that an interrupted run resumes."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from q2q_model.documents.json_file import with_nulls
from q2q_model.documents.written_file import write_text
from q2q_model.downwash.jet import Jet
from q2q_model.model_files.model_file import ModelFile, decode, encode
from q2q_model.signals.values import Array
from q2q_sim.experiments.ablation.ablation_cases import Case
from q2q_sim.experiments.ablation.learned_models import MOST, LearnedModel

DIGITS = 3
"""Significant digits that are kept."""


@dataclass(slots=True)
class Numbers:
    """Finished flights, and what was learned for them."""

    draws: int
    """Draws with each model of a part of a family's flights."""
    models: dict[str, list[LearnedModel]] = field(default_factory=dict)
    """By the family of their flights."""
    airs: dict[str, list[str]] = field(default_factory=dict)
    """Flights behind each learned air, by its name."""
    flights: dict[str, Array] = field(default_factory=dict)
    """COLUMNS of each draw (draws, 3), by `cell_name`."""

    def cell(self, case: Case, variant: str) -> Array | None:
        """Return COLUMNS of all models and draws, (models, draws, 3); None unless flown."""
        flown = self.flights.get(cell_name(case, variant))
        if flown is None:
            return None
        models, paths = len(self.models_for(case)), len(case.paths.scenarios)
        draws = flown.reshape(-1, models, paths, flown.shape[-1])  # draw k has model k mod models
        return np.asarray(draws.swapaxes(0, 1).reshape(models, -1, flown.shape[-1]))

    def models_for(self, case: Case) -> Sequence[LearnedModel]:
        """Return the models of a case's controllers; none before they are learned."""
        learned = self.models.get(case.plant.models, [])
        return learned[-1:] if case.paths.draws else learned[:-1]

    def draws_of(self, case: Case) -> int:
        """Return the draws that are flown in a case, of all models together."""
        return case.paths.draws or MOST * self.draws

    def save(self, file: Path) -> None:
        """Replace a file by these numbers."""
        models = {
            family: [[one.name, encode(ModelFile(one.jet, residual=one.residual))] for one in learned]
            for family, learned in self.models.items()
        }
        known = json.dumps({"draws": self.draws, "airs": self.airs, "models": models}, indent=1)
        flights = ",\n".join(
            f"  {json.dumps(name)}: {json.dumps(with_nulls(_rounded(rows)))}"
            for name, rows in sorted(self.flights.items())
        )
        text = f'{known[:-2]},\n "flights": {{\n{flights}\n }}\n}}\n'  # a line for each cell
        write_text(text, file)


def cell_name(case: Case, variant: str) -> str:
    """Return the name of a cell."""
    return f"{case.name}|{case.plant.air}|{variant}"


def read_numbers(file: Path, draws: int) -> Numbers:
    """Return the numbers in a file, empty if there is none; raise ValueError for other draws."""
    if not file.is_file():
        return Numbers(draws)
    try:
        body = json.loads(file.read_text(encoding="utf-8"))
        found = Numbers(int(body["draws"]), airs={str(k): list(v) for k, v in body["airs"].items()})
        found.models = {family: _models(texts) for family, texts in body["models"].items()}
        found.flights = {name: np.array(rows, dtype=np.float64) for name, rows in body["flights"].items()}
    except (KeyError, TypeError, AttributeError, ValueError, RecursionError) as wrong:
        raise ValueError(f"{file} is not an ablation ({wrong}): remove it, or give another --json") from wrong
    if found.draws != draws:
        raise ValueError(
            f"{file} holds {found.draws} draws, not {draws}: give another --json, or --draws {found.draws}"
        )
    return found


def _rounded(rows: Array) -> list[list[float]]:
    return [[float(f"{value:.{DIGITS}g}") for value in row] for row in rows]


def _models(texts: Sequence[Sequence[str]]) -> list[LearnedModel]:
    found = []
    for name, text in texts:
        content = decode(text)
        if not isinstance(content.interaction, Jet):
            raise ValueError(f"{name} is not a jet")  # noqa: TRY004  a bad document
        found.append(LearnedModel(name, content.interaction, content.residual))
    return found
