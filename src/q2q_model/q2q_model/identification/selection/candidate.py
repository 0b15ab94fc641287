"""A candidate for the interaction model of flights: a family of models to fit."""

from dataclasses import dataclass

from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.identification.selection.cross_validation import Fitter


@dataclass(frozen=True, slots=True)
class Candidate:
    """Model family to fit."""

    name: str
    kind: str
    """Model type, as in a model file."""
    parameters: int
    fit: Fitter


NOTHING = Candidate("no downwash", "none", 0, lambda _: NoInteraction())
"""Candidate for air without downwash, where a jet would fit noise."""
