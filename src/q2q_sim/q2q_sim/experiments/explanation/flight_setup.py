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
class FlightSetup:
    """Setup of a flight: all that decides it."""

    scenario: Scenario
    options: BlockChoices
    seed: int
    plan: SwarmPlan
    air: FlownAir | None
    """Air in place of the scenario's wake and disturbance; None keeps those."""


def flight_setup(scenario: Scenario, options: BlockChoices, seed: int) -> FlightSetup:
    """Return the flight of a scenario in its own air, along its own plan.

    Raises:
        ValueError: the air or the plan does not exist.
    """
    air = air_of(scenario) if scenario.air else None
    return FlightSetup(scenario, options, seed, plan_of(scenario), air)


def fly_setup(setup: FlightSetup) -> Flight:
    """Fly a flight without ROS as set up; return its recording."""
    options, known = setup.options, find_model(setup.scenario.model)
    return fly(
        setup.scenario,
        FlightOptions(
            mode=next(mode for mode in MODES if mode == options.mode),
            controller=options.controller,
            replan=options.replan,
            seed=setup.seed,
            model=known.interaction,
            air=setup.air,
            plan=setup.plan,
            residual_process=(known.residual or REAL_FLIGHTS) if options.correct else None,
        ),
    )
