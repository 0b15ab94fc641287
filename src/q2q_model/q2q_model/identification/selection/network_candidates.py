"""The paper's networks among the candidates, with the flights that are too long for them."""

from collections.abc import Mapping, Sequence
from functools import partial

from q2q_model.downwash.envelope_network import EnvelopeNetwork
from q2q_model.identification.networks.fit import NetworkFitParams, fit_networks
from q2q_model.identification.networks.gradient import ONE
from q2q_model.identification.networks.trajectory_loss import (
    MOST_ACTIVE,
    WIDE,
    FlightTerms,
    active_samples,
    flight_terms,
)
from q2q_model.identification.selection.candidate import Candidate
from q2q_model.identification.selection.identification_data import IdentificationData
from q2q_model.vehicle.altitude_loop import AltitudeLoop

NETWORKS = "the paper's two networks"


def network_candidates(flights: Sequence[IdentificationData], loop: AltitudeLoop) -> list[Candidate]:
    """Return the networks, whose loss is prepared once for all subsets of the flights."""
    params = NetworkFitParams()
    terms = {
        one.name: [flight_terms(record, loop, _reach(params)) for record in one.records] for one in flights
    }

    return [Candidate(NETWORKS, "envelope_network", 2 * ONE, partial(_fitted_networks, terms, params))]


def _fitted_networks(
    terms: Mapping[str, Sequence[FlightTerms]], params: NetworkFitParams, chosen: Sequence[IdentificationData]
) -> EnvelopeNetwork:
    return fit_networks([part for one in chosen for part in terms[one.name]], params)


def network_notes(kind: str, flights: Sequence[IdentificationData]) -> list[str]:
    """Return a remark on long encounters: auto omits the networks, else flights are decimated."""
    if kind == "jet" or not (long := long_encounters(flights)):
        return []
    which = f"{', '.join(long)}: over {MOST_ACTIVE} samples with a pair in reach"
    if kind == "auto":
        return [
            f"{NETWORKS}: not tried ({which}); --model-type envelope_network fits them in minutes, thinned"
        ]
    return [f"{NETWORKS}: fitted to thinned flights ({which})"]


def long_encounters(flights: Sequence[IdentificationData]) -> list[str]:
    """Return the names of flights with more active samples than `MOST_ACTIVE`."""
    reach = _reach(NetworkFitParams())
    return [
        one.name
        for one in flights
        if any(active_samples(record, reach).size > MOST_ACTIVE for record in one.records)
    ]


def _reach(params: NetworkFitParams) -> tuple[float, float]:
    return WIDE * params.envelope.eps, WIDE * params.envelope.d
