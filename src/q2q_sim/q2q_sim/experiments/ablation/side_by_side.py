"""Many draws of a flight in one room.

Draws are SPACING apart, out of reach of each other's downwash, each with its own noise, losses, gusts,
residual and vehicles: one flight gives as many independent samples as draws.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from q2q_model.signals.values import Names
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory
from q2q_planner.plan_playback.plan_waypoints import waypoints_of
from q2q_sim.loop.flight_blocks import plan_of
from q2q_sim.scenarios.scenario import Scenario

SPACING = 10.0
"""Between draws [m]: ten times the reach of any downwash; 36 of them lie within +-30 m."""
COLUMNS = 6
"""Draws in a row."""


def side_by_side(flown: Sequence[Scenario], count: int) -> Scenario:
    """Return `count` draws of scenarios that differ in their plans only, as one scenario.

    Draw k of scenario f has place k * len(flown) + f; the vehicles of a place follow each other.
    """
    names: list[str] = []
    trajectories: list[Trajectory] = []
    rows = (count * len(flown) + COLUMNS - 1) // COLUMNS
    for place in range(count * len(flown)):
        one = plan_of(flown[place % len(flown)])
        aside = (SPACING * (place % COLUMNS - COLUMNS // 2), SPACING * (place // COLUMNS - rows // 2))
        names += [f"{name}_{place}" for name in one.names]
        trajectories += [_moved(trajectory, aside) for trajectory in one.trajectories]
    plan = SwarmPlan(tuple(names), tuple(trajectories))
    return replace(flown[0], plan=plan, waypoints=waypoints_of(plan))


def with_vehicles(scenario: Scenario, names: Names) -> Scenario:
    """Return a scenario with some of its vehicles only."""
    plan = plan_of(scenario)
    rows = [plan.names.index(name) for name in names]
    own = SwarmPlan(names, tuple(plan.trajectories[row] for row in rows))
    return replace(scenario, plan=own, waypoints=tuple(scenario.waypoints[row] for row in rows))


def _moved(trajectory: Trajectory, aside: tuple[float, float]) -> Trajectory:
    moved = np.copy(trajectory.coefficients)
    moved[:, :2, 0] += aside
    return Trajectory(trajectory.durations, moved)
