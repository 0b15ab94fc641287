"""Planned trajectories of a scenario."""

from q2q.identified_model import ModelChoice, flown_model
from q2q.scenario_choice import ScenarioChoice, scenario
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_sim.loop.flight_blocks import plan_around, plan_of


def plan(chosen: ScenarioChoice, *, around: ModelChoice | None = None) -> SwarmPlan:
    """Return minimum-snap trajectories through a scenario's waypoints.

    Args:
        chosen: scenario, or its name, file or document; see `q2q.scenario`.
        around: interaction model whose downwash every pair avoids, certified for every t; None plans without
            avoidance.

    Raises:
        InfeasibleError: no such plan was found.
        ValueError: a choice, or an output of a model, that is not allowed; the message says what is.
        TypeError: `around` is no model.
    """
    path = scenario(chosen)
    return plan_of(path) if around is None else plan_around(path, flown_model(around))
