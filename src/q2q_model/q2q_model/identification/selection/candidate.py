"""A candidate for the interaction model of flights: a family of models to fit."""

from collections.abc import Sequence
from dataclasses import dataclass

from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.identification.selection.cross_validation import Fitter
from q2q_model.identification.selection.identification_data import IdentificationData


@dataclass(frozen=True, slots=True)
class Candidate:
    """Model family to fit."""

    name: str
    kind: str
    """Model type, as in a model file."""
    parameters: int
    fit: Fitter
    """Can be pickled, as results of `identify` are passed between processes."""


def _no_interaction(_flights: Sequence[IdentificationData]) -> NoInteraction:
    return NoInteraction()


NOTHING = Candidate("no downwash", "none", 0, _no_interaction)
"""Candidate for air without downwash, where a jet would fit noise."""
