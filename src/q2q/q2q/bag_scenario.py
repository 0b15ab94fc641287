"""Scenario file in a bag, for flights of scenarios that their names do not give: documents, changed ones."""

import warnings
from dataclasses import replace
from pathlib import Path

from q2q_model.bag import FlightFacts
from q2q_model.documents.plain_values import Plain
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, is_named, vehicle_by_name
from q2q_sim.flight_bag.scenario_facts import flown_scenario
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_to_document import document_of

FILE = "scenario.yaml"
"""Name of the file in the bag's folder."""


def bag_document(flown: Scenario, facts: FlightFacts) -> dict[str, Plain] | None:
    """Return the document of a flight's scenario; None if its metadata give it.

    What no document holds, its plan or a vehicle of no name, is a warning, and left out.
    """
    if _is_named(flown, facts):
        return None
    document = document_of(flown)
    if document is None:
        warnings.warn(
            f"{flown.name}: a bag does not store its {_left_out(flown)}; the flight cannot be flown again "
            "from its bag",
            stacklevel=3,
        )
        document = document_of(_without_plan_or_own_vehicle(flown))
    return document


def _left_out(flown: Scenario) -> str:
    plan = "" if flown.plan is None else "plan"
    vehicle = "" if is_named(flown.vehicle) else "vehicle, which is none by name"
    return " and ".join(filter(None, (plan, vehicle))) or "changed values"


def _without_plan_or_own_vehicle(flown: Scenario) -> Scenario:
    vehicle = flown.vehicle if is_named(flown.vehicle) else vehicle_by_name(DEFAULT_VEHICLE)
    return replace(flown, plan=None, vehicle=vehicle)


def _is_named(flown: Scenario, facts: FlightFacts) -> bool:
    """Return whether the metadata give the scenario; they have its model and duration as well."""
    try:
        found = flown_scenario(facts, Path())
    except ValueError:
        return False
    return replace(found, in_air=None, model="none", duration=1.0) == replace(
        flown, in_air=None, model="none", duration=1.0
    )
