"""Candidate interaction models: forms of the jet, then the paper's networks."""

from collections.abc import Sequence
from dataclasses import replace

from q2q_model.identification.selection.candidate import NOTHING, Candidate
from q2q_model.identification.selection.identification_data import (
    IdentificationData,
    every_record,
    has_exposure,
)
from q2q_model.identification.selection.jet_candidates import jet_candidates
from q2q_model.identification.selection.network_candidates import long_encounters, network_candidates
from q2q_model.vehicle.altitude_loop import AltitudeLoop


def candidates(kind: str, flights: Sequence[IdentificationData], loop: AltitudeLoop) -> list[Candidate]:
    """Return the candidates of a kind: auto, jet or envelope_network; "none" for flights without downwash.

    Raises:
        ValueError: an unknown kind.
    """
    kinds = {
        "auto": (jet_candidates, network_candidates),
        "jet": (jet_candidates,),
        "envelope_network": (network_candidates,),
    }
    if kind not in kinds:
        raise ValueError(f"unknown model type {kind!r}: choose one of {', '.join(kinds)}")
    if not any(has_exposure(record) for record in every_record(flights)):
        return [replace(NOTHING, name="no downwash: nobody flew under another")]
    kept = kinds[kind]
    if kind == "auto" and long_encounters(flights):
        kept = (jet_candidates,)
    return [one for made in kept for one in made(flights, loop)]
