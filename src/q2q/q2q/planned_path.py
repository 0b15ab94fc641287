"""Planned trajectories of a scenario."""

from q2q.identified_model import ModelChoice, flown_model
from q2q.scenario_choice import ScenarioChoice, scenario
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_planner.offline.minimum_snap.feasibility import check_feasible
from q2q_sim.loop.flight_blocks import plan_around, plan_of


def plan(chosen: ScenarioChoice, *, around: ModelChoice | None = None) -> SwarmPlan:
    """Return minimum-snap trajectories through a scenario's waypoints, which its vehicles can fly.

    A plan around a model is certified to keep every pair, for every t, out of the smallest level set of the
    model's downwash whose avoidance removes 88 % of the predicted height error of every vehicle, or leaves
    less than 1 mm. The zone of the model's file is used only if the model has no downwash: for a zone of a
    given size, give `dataclasses.replace(q2q.load_model("none"), zone=...)`.

    Args:
        chosen: scenario, or its name, file or document; see `q2q.scenario`.
        around: interaction model whose downwash every pair avoids; None plans without avoidance.

    Raises:
        InfeasibleError: no such plan was found.
        NotFlyableError: it needs more thrust, tilt or yaw rate than a vehicle has.
        ValueError: a choice, or an output of a model, that is not allowed; the message says what is.
        TypeError: `around` is no model.
    """
    path = scenario(chosen)
    if around is not None:
        return plan_around(path, flown_model(around))
    made = plan_of(path)
    check_feasible(made, path.waypoints, path.vehicle)
    return made
