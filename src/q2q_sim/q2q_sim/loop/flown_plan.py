"""Plans that a scenario's vehicles can fly: theirs, by name, from where they start."""

from dataclasses import replace
from math import dist

from q2q_model.counted import difference, listed
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_sim.scenarios.scenario import Scenario

START_NEAR = 0.1
"""Largest distance of a vehicle's start from its plan's first point [m]."""


def plan_for(flown: Scenario, given: SwarmPlan) -> SwarmPlan:
    """Return a plan with its vehicles in the order of a scenario's.

    Raises:
        TypeError: it is no plan.
        ValueError: it is for other vehicles, or begins elsewhere.
    """
    if not isinstance(given, SwarmPlan):
        raise TypeError(f"plan = {given!r}; must be a result of q2q.plan")
    if wrong := difference(given.names, flown.names):
        raise ValueError(f"the plan {wrong}: the vehicles of the scenario are {listed(flown.names)}")
    rows = map(given.names.index, flown.names)
    ordered = replace(given, names=flown.names, trajectories=tuple(given.trajectories[row] for row in rows))
    for one, first in zip(flown.waypoints, setpoint_at(ordered, 0.0).pos, strict=True):
        far = dist(one.waypoints[0].pos, first)
        if not far <= START_NEAR:
            raise ValueError(
                f"{one.name} starts {far:.2f} m from its plan's first point (maximum {START_NEAR} m)"
            )
    return ordered
