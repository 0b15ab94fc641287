"""Jets among the candidates: the forms that are tried, fitted to measured pushes or else to altitudes."""

from collections.abc import Sequence
from functools import partial

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.jet import Jet
from q2q_model.identification.jet.held_out_deviation import with_held_out_deviation
from q2q_model.identification.jet.jet_fit import JetFit, fit_to_altitudes, fit_to_pushes, may_be_stacked
from q2q_model.identification.jet.jet_form import JetForm, free_names
from q2q_model.identification.selection.candidate import NOTHING, Candidate
from q2q_model.identification.selection.identification_data import (
    IdentificationData,
    every_record,
    measures_downwash,
)
from q2q_model.identification.statistics.intervals import Interval
from q2q_model.vehicle.altitude_loop import AltitudeLoop

FORMS = {
    "jet, straight down, power law": JetForm("power", carried=0.0, delayed=False),
    "jet, straight down, exponential": JetForm("exponential", carried=0.0, delayed=False),
    "jet, delayed": JetForm("exponential", carried=0.0, delayed=True),
    "jet, delayed, moving with its source": JetForm("exponential", carried=1.0, delayed=True),
    "jet, delayed, moving, loaded": JetForm("exponential", carried=1.0, delayed=True, loaded=True),
}


def jet_candidates(flights: Sequence[IdentificationData], loop: AltitudeLoop) -> list[Candidate]:
    """Return the forms of the jet, after no downwash where that can be tried.

    A loaded form needs measured pushes.
    """
    measured = measures_downwash(flights)
    nothing = [NOTHING] if measured and len(flights) > 1 else []  # of one flight nothing can be held out
    forms = {name: form for name, form in FORMS.items() if measured or not form.loaded}
    stacked = may_be_stacked([one for flight in flights for one in flight.pushes])
    free = {name: len(free_names(form, stacked=stacked)) for name, form in forms.items()}
    made = [
        Candidate(name, "jet", free[name], partial(_fitted_jet, loop, form)) for name, form in forms.items()
    ]
    return nothing + made


def _fitted_jet(loop: AltitudeLoop, form: JetForm, flights: Sequence[IdentificationData]) -> Jet:
    return fit_jet(flights, loop, form).jet


def fit_jet(
    flights: Sequence[IdentificationData], loop: AltitudeLoop, form: JetForm, solved: Jet | None = None
) -> JetFit:
    """Return the jet of a form fitted to measured pushes if there are any, else to altitudes.

    `solved` is that jet if known already: then only its intervals are computed.
    """
    pushes = [one for flight in flights for one in flight.pushes]
    if measures_downwash(flights):
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
