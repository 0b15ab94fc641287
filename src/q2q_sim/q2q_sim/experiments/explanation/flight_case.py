"""Everything that decides a simulated flight, so that it can be flown again or changed."""

from dataclasses import dataclass

from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.flights.flight import Flight
from q2q_model.model_files.find_model import find_model
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import MODES, BlockChoices, plan_of
from q2q_sim.loop.scenario_air import air_of
from q2q_sim.scenarios.scenario import Scenario


@dataclass(frozen=True, slots=True)
class FlightCase:
    """Flight of a scenario."""

    scenario: Scenario
    options: BlockChoices
    seed: int
    plan: SwarmPlan
    air: FlownAir | None
    """Air in place of the scenario's wake and disturbance; None keeps those."""


def flight_case(scenario: Scenario, options: BlockChoices, seed: int) -> FlightCase:
    """Return the flight of a scenario in its own air, along its own plan.

    Raises:
        ValueError: the air or the plan does not exist.
    """
    air = air_of(scenario) if scenario.air else None
    return FlightCase(scenario, options, seed, plan_of(scenario), air)


def fly_flight_case(case: FlightCase) -> Flight:
    """Fly a case without ROS and return the recording."""
    options, known = case.options, find_model(case.scenario.model)
    return fly(
        case.scenario,
        FlightOptions(
            mode=next(mode for mode in MODES if mode == options.mode),
            controller=options.controller,
            replan=options.replan,
            seed=case.seed,
            model=known.interaction,
            air=case.air,
            plan=case.plan,
            residual_process=(known.residual or REAL_FLIGHTS) if options.correct else None,
        ),
    )
