"""The shipped numbers of the ablation, for tests."""

import os
from pathlib import Path

from q2q_model.downwash.jet import Jet
from q2q_sim.experiments.ablation.ablation_cases import (
    SHOWN,
    Case,
)
from q2q_sim.experiments.ablation.ablation_numbers import Numbers, read_numbers
from q2q_sim.experiments.ablation.learned_models import LearnedModel

ROOT = Path(__file__).resolve().parents[3]
DATA = Path(os.environ.get("Q2Q_DATA", ROOT.parent / "shared" / "data"))
DRAWS = 4
"""Draws with each model behind the page in the documents."""
SHORT = 0.3
"""Ends before anything but the start of a flight has happened [s]."""
PASSAGE, STACK = (Case(name) for name in SHOWN)
STRONG, WEAK = (LearnedModel(name, Jet(strength=k)) for name, k in (("strong", 4.0), ("weak", 0.5)))


def shipped() -> Numbers:
    """Return the numbers behind the page in the documents."""
    return read_numbers(ROOT / "docs" / "ablation.json", DRAWS)
