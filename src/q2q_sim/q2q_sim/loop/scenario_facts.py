"""Metadata of a scenario's flight, for its bag."""

from q2q_model.bag import FlightFacts
from q2q_model.vehicle.constants import firmware_of
from q2q_sim.loop.assembly import Options
from q2q_sim.loop.scenario_air import air_description
from q2q_sim.scenarios.scenario import Scenario


def scenario_facts(scenario: Scenario, options: Options, seed: int, name: str = "") -> FlightFacts:
    """Return the metadata of a flight; `name` is that of the scenario or its file, if not its own."""
    return FlightFacts(
        vehicle=scenario.vehicle.name,
        firmware=firmware_of(scenario.vehicle),
        scenario=name or scenario.name,
        mode=options.mode,
        controller=options.controller,
        correct="true" if options.correct else "",
        model=scenario.model,
        wake="" if scenario.air else scenario.wake,
        air=air_description(scenario),
        seed=str(seed),
        duration=f"{scenario.duration:g}",
    )
