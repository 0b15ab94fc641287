"""Why an identified model is not to be flown with, as far as its own flights show it."""

from collections.abc import Sequence

from q2q_model.identification.flight_evidence import FlightEvidence
from q2q_model.identification.gains.command_gains import GainFit
from q2q_model.identification.selection.candidates import NOTHING, Trial


def doubts(gains: GainFit, best: Trial, evidence: Sequence[FlightEvidence]) -> list[str]:
    """Return remarks on a model of which the flights do not show that it holds."""
    found = []
    known = gains.k_p.is_positive and gains.k_d.is_positive
    if best.candidate.kind != NOTHING.kind and not known and not any(one.pushes for one in evidence):
        found.append(
            "the downwash is inferred by gains that these flights do not determine, and is no better known: "
            "record the topics command and state, or command and imu, which measure it"
        )
    share = best.held_out.r2.lower
    if best.candidate.kind != NOTHING.kind and share is not None and share <= 0.0:
        found.append(
            f"on flights left out the model is no better than none (R2 {share:.3f}): do not compensate by it"
        )
    return found
