"""Planned trajectories of a scenario."""

from dataclasses import replace
from math import dist

from q2q.identified_model import ModelChoice, flown_model
from q2q.scenario_choice import ScenarioChoice, scenario
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_sim.loop.flight_blocks import plan_around, plan_of
from q2q_sim.scenarios.scenario import Scenario

START_NEAR = 0.1
"""Largest distance of a vehicle's start from its plan's first point [m]."""


def plan(chosen: ScenarioChoice, *, around: ModelChoice | None = None) -> SwarmPlan:
    """Return minimum-snap trajectories through a scenario's waypoints.

    Args:
        chosen: scenario, or its name, file or document; see `q2q.scenario`.
        around: interaction model whose downwash every pair avoids, certified for every t; None plans without
            avoidance.

    Raises:
        InfeasibleError: no such plan was found.
        ValueError: a choice, or an answer of a model, that is not allowed; the message says what is.
        TypeError: `around` is no model.
    """
    path = scenario(chosen)
    return plan_of(path) if around is None else plan_around(path, flown_model(around))


def plan_for(flown: Scenario, given: SwarmPlan) -> SwarmPlan:
    """Return a plan with its vehicles in the order of a scenario's.

    Raises:
        TypeError: it is no plan.
        ValueError: it is for other vehicles, or begins elsewhere.
    """
    if not isinstance(given, SwarmPlan):
        raise TypeError(f"plan = {given!r}: what q2q.plan returns is expected")
    if set(given.names) != set(flown.names):
        raise ValueError(
            f"the plan is for {', '.join(given.names)}, the scenario has {', '.join(flown.names)}"
        )
    rows = map(given.names.index, flown.names)
    ordered = replace(given, names=flown.names, trajectories=tuple(given.trajectories[row] for row in rows))
    for one, first in zip(flown.waypoints, setpoint_at(ordered, 0.0).pos, strict=True):
        far = dist(one.waypoints[0].pos, first)
        if not far <= START_NEAR:
            raise ValueError(
                f"{one.name} starts {far:.2f} m from its plan's first point: {START_NEAR} m is the maximum"
            )
    return ordered
