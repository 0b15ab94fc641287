"""Scenario file in a bag, for flights of scenarios that their names do not give: documents, changed ones."""

from dataclasses import replace
from pathlib import Path

from q2q_model.bag import FlightFacts
from q2q_model.documents.plain_values import Plain
from q2q_sim.loop.scenario_facts import flown_scenario
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.written_scenario import document_of

FILE = "scenario.yaml"
"""Name of the file in the bag's folder."""


def bag_document(flown: Scenario, facts: FlightFacts) -> dict[str, Plain] | None:
    """Return the document of a flight's scenario; None if its metadata give it, or no document does."""
    return None if _is_named(flown, facts) else document_of(flown)


def _is_named(flown: Scenario, facts: FlightFacts) -> bool:
    """Return whether the metadata give the scenario; they have its model and duration beside it."""
    try:
        found = flown_scenario(facts, Path())
    except ValueError:
        return False
    return replace(found, in_air=None, model="none", duration=1.0) == replace(
        flown, in_air=None, model="none", duration=1.0
    )
