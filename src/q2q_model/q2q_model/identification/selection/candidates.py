"""Candidate interaction models, and the choice among them by held-out error.

Candidates are several forms of the jet and the paper's networks. They are fitted to measured pushes if there
are any, else to altitudes. A later candidate, with more parameters, replaces an earlier one only if it lowers
the held-out error by more than `MARGIN`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from q2q_model.downwash.envelope_network import EnvelopeNetwork
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.jet import Jet
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.forked import forked
from q2q_model.identification.identification_data import IdentificationData, every_record, has_exposure
from q2q_model.identification.intervals import Interval
from q2q_model.identification.networks.fit import NetworkFitParams, fit_networks
from q2q_model.identification.networks.trajectory_loss import MOST_ACTIVE, WIDE, active_samples, flight_terms
from q2q_model.identification.push.held_out_deviation import with_held_out_deviation
from q2q_model.identification.push.jet_fit import JetFit, fit_to_altitudes, fit_to_pushes
from q2q_model.identification.push.jet_form import JetForm
from q2q_model.identification.selection.cross_validation import Fitter, Score, score_held_out
from q2q_model.vehicle.altitude_loop import AltitudeLoop

NETWORKS = "the paper's two networks"
FAILURES = (ValueError, np.linalg.LinAlgError)
"""Exceptions of a fit that fails."""
MARGIN = 0.02
"""Relative reduction of the held-out error required of a model with more parameters [-]."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """Model family to fit."""

    name: str
    kind: str
    """Model type, as in a model file."""
    parameters: int
    fit: Fitter


@dataclass(frozen=True, slots=True)
class Trial:
    """Candidate and its score on held-out flights."""

    candidate: Candidate
    held_out: Score


NOTHING = Candidate("no downwash", "none", 0, lambda _: NoInteraction())
"""Candidate for air without downwash, where a jet would fit noise."""

FORMS = {
    "jet, straight down, power law": JetForm("power", carried=0.0, delayed=False),
    "jet, straight down, exponential": JetForm("exponential", carried=0.0, delayed=False),
    "jet, delayed": JetForm("exponential", carried=0.0, delayed=True),
    "jet, delayed, moving with its source": JetForm("exponential", carried=1.0, delayed=True),
    "jet, delayed, moving, loaded": JetForm("exponential", carried=1.0, delayed=True, loaded=True),
}


def candidates(kind: str, flights: Sequence[IdentificationData], loop: AltitudeLoop) -> list[Candidate]:
    """Return the candidates of a kind: auto, jet or envelope_network; "none" for flights without downwash.

    Raises:
        ValueError: an unknown kind.
    """
    kinds = {"auto": (_jets, _networks), "jet": (_jets,), "envelope_network": (_networks,)}
    if kind not in kinds:
        raise ValueError(f"unknown model type {kind!r}: choose one of {', '.join(kinds)}")
    if not any(has_exposure(record) for record in every_record(flights)):
        return [replace(NOTHING, name="no downwash: nobody flew under another")]
    kept = kinds[kind]
    if kind == "auto" and _long_encounters(flights):
        kept = (_jets,)
    return [one for made in kept for one in made(flights, loop)]


def network_notes(kind: str, flights: Sequence[IdentificationData]) -> list[str]:
    """Return a remark on long encounters: auto omits the networks, else flights are decimated."""
    if kind == "jet" or not (long := _long_encounters(flights)):
        return []
    which = f"{', '.join(long)}: over {MOST_ACTIVE} samples with a pair in reach"
    if kind == "auto":
        return [
            f"{NETWORKS}: not tried ({which}); --model-type envelope_network fits them in minutes, thinned"
        ]
    return [f"{NETWORKS}: fitted to thinned flights ({which})"]


def score_candidates(
    tried: Sequence[Candidate],
    flights: Sequence[IdentificationData],
    loop: AltitudeLoop,
    on_step: Callable[[str], None],
) -> tuple[list[Trial], list[str]]:
    """Return each candidate's held-out score, and remarks on those that cannot be fitted.

    `on_step` is called with the name of each candidate before its fit. The last one, which takes about as
    long as all others, is fitted in addition.
    """
    trials: list[Trial] = []
    remarks: list[str] = []
    works: list[Callable[[], Score]] = [
        partial(score_held_out, candidate.fit, flights, loop) for candidate in tried
    ]
    works[-1] = forked(works[-1])
    for candidate, work in zip(tried, works, strict=True):
        on_step(candidate.name)
        try:
            trials.append(Trial(candidate, work()))
        except FAILURES as failure:
            remarks.append(f"{candidate.name}: dropped, {failure}")
    return trials, remarks


def fit_best(
    trials: Sequence[Trial], flights: Sequence[IdentificationData], failed: Sequence[str] = ()
) -> tuple[Trial, InteractionModel, list[str]]:
    """Return the best trial, its model fitted to all flights, and remarks on better ones that fail to fit.

    `failed` are the remarks on candidates without a trial.

    Raises:
        ValueError: no candidate can be fitted; the message has the reason of each.
    """
    left = list(trials)
    remarks: list[str] = []
    while left:
        best = best_trial(left)
        try:
            return best, best.candidate.fit(flights), remarks
        except FAILURES as failure:
            remarks.append(f"{best.candidate.name}: dropped, {failure}")
            left.remove(best)
    raise ValueError(f"no model can be fitted to these flights: {'; '.join([*failed, *remarks])}")


def best_trial(trials: Sequence[Trial]) -> Trial:
    """Return the trial with the least held-out error, the earlier of two within `MARGIN`."""
    best = trials[0]
    for trial in trials[1:]:
        if trial.held_out.unexplained < (1.0 - MARGIN) * best.held_out.unexplained:
            best = trial
    return best


def fit_jet(
    flights: Sequence[IdentificationData], loop: AltitudeLoop, form: JetForm, solved: Jet | None = None
) -> JetFit:
    """Return the jet of a form fitted to measured pushes if there are any, else to altitudes.

    `solved` is that jet if known already: then only its intervals are computed.
    """
    pushes = [one for flight in flights for one in flight.pushes]
    if any(one.exposed.any() for one in pushes):
        return fit_to_pushes(pushes, form, solved)
    return fit_to_altitudes(every_record(flights), loop, form, solved)


def with_deviation(
    found: Candidate, model: InteractionModel, flights: Sequence[IdentificationData]
) -> InteractionModel:
    """Return a candidate's model, a jet with its deviation on held-out flights."""
    pushes = [one for flight in flights for one in flight.pushes]
    if found.name in FORMS and isinstance(model, Jet):
        return with_held_out_deviation(model, pushes, FORMS[found.name])
    return model


def parameter_intervals(
    found: Candidate, model: InteractionModel, flights: Sequence[IdentificationData], loop: AltitudeLoop
) -> tuple[tuple[str, Interval], ...]:
    """Return the intervals of the parameters of a candidate's model, by name; empty unless it is a jet."""
    if found.name not in FORMS or not isinstance(model, Jet):
        return ()
    return fit_jet(flights, loop, FORMS[found.name], model).intervals


def _jets(flights: Sequence[IdentificationData], loop: AltitudeLoop) -> list[Candidate]:
    measured = any(one.exposed.any() for flight in flights for one in flight.pushes)
    nothing = [NOTHING] if measured and len(flights) > 1 else []  # of one flight nothing can be held out
    forms = {name: form for name, form in FORMS.items() if measured or not form.loaded}
    made = [Candidate(name, "jet", _freedom(form), _jet_fitter(loop, form)) for name, form in forms.items()]
    return nothing + made


def _freedom(form: JetForm) -> int:
    return 4 + form.delayed + form.spreading + 3 * form.loaded


def _jet_fitter(loop: AltitudeLoop, form: JetForm) -> Fitter:
    def fit(flights: Sequence[IdentificationData]) -> InteractionModel:
        return fit_jet(flights, loop, form).jet

    return fit


def _long_encounters(flights: Sequence[IdentificationData]) -> list[str]:
    """Return the names of flights with more active samples than `MOST_ACTIVE`."""
    reach = _reach(NetworkFitParams())
    return [
        one.name
        for one in flights
        if any(active_samples(record, reach).size > MOST_ACTIVE for record in one.records)
    ]


def _reach(params: NetworkFitParams) -> tuple[float, float]:
    return WIDE * params.envelope.eps, WIDE * params.envelope.d


def _networks(flights: Sequence[IdentificationData], loop: AltitudeLoop) -> list[Candidate]:
    params = NetworkFitParams()
    terms = {
        one.name: [flight_terms(record, loop, _reach(params)) for record in one.records] for one in flights
    }

    def fit(chosen: Sequence[IdentificationData]) -> EnvelopeNetwork:
        return fit_networks([part for one in chosen for part in terms[one.name]], params)

    return [Candidate(NETWORKS, "envelope_network", 322, fit)]
