"""Cases of the ablation: paths, the air they are flown in, and the flights behind the controllers' models.

Controllers are given models learned from recorded flights of one family (learned_models), in air that shares
no flight with them: an air learned from another family, or one of another form. The air `paper` is the
exception: model and air are one law.

All paths are flown by the vehicles, in the room, and with the gains of `table6_room` in an air; of each path
the part around its passages is flown, and the first 3 s of that are not judged
(q2q_sim.monitors.metrics.exposure).
"""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory
from q2q_planner.offline.certificate.shared_pieces import split_at
from q2q_planner.plan_playback.plan_waypoints import waypoints_of
from q2q_sim.air.air_names import RECORDED, ROOM, SYNTHETIC
from q2q_sim.loop.flight_blocks import plan_of
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_variants import with_air

PASSAGE = "table6_room"
SIX_FLIGHTS = "table2"
LAW = "paper"
"""Air whose law is the controllers' model."""


@dataclass(frozen=True, slots=True)
class Paths:
    """Part of one or more scenarios that is flown; several fly at once, apart from each other."""

    scenarios: tuple[str, ...]
    start: float
    """Time of the scenario at which the flight starts [s]."""
    end: float
    """[s]"""
    draws: int = 0
    """Draws, all with the model of all flights; 0 for several draws with each model of a part of them."""


PATHS = {
    PASSAGE: Paths((PASSAGE,), 15.0, 36.5),
    "stack3": Paths(("stack3",), 12.0, 28.5),
    "crossing": Paths(("crossing",), 17.0, 34.5, draws=5),
    SIX_FLIGHTS: Paths(tuple(f"table2_{k}" for k in range(1, 7)), 15.0, 25.0, draws=5),
}
"""By name, the most important first."""


@dataclass(frozen=True, slots=True)
class Plant:
    """Air of a case, and the flights behind its controllers' models."""

    air: str
    """Name of the air (q2q_sim.air.air_names)."""
    family: str
    """Recorded flights behind the air: the start of their names; empty for none."""
    models: str
    """Recorded flights behind the models; LAW for the law of that name."""


PLANTS = (
    Plant(ROOM, "dc21", "dc19"),
    Plant(RECORDED, "dc21", "dc19"),
    *(Plant(air, "dc19", "dc21") for air in SYNTHETIC),  # as strong as a law fitted to dc19
    Plant(LAW, "", LAW),
)
SHIPPED = PLANTS[0]


@dataclass(frozen=True, slots=True)
class Case:
    """Paths and plant of a table."""

    name: str
    """Key of PATHS."""
    plant: Plant = SHIPPED

    @property
    def title(self) -> str:
        """Return the heading of the case's table."""
        return f"{self.name}, air {self.plant.air}"

    @property
    def paths(self) -> Paths:
        """Return the paths."""
        return PATHS[self.name]


JUDGED = tuple(plant for plant in PLANTS if plant.air != LAW)
"""Plants whose air is not of the models' family."""
SHOWN = (PASSAGE, "stack3")
"""Paths of the conclusion and the plot."""
CASES = tuple(Case(name, plant) for name in PATHS for plant in PLANTS)


def scenarios_of(name: str) -> tuple[Scenario, ...]:
    """Return the scenarios of PATHS[name], cut to the flown part; their air is given to the closed loop."""
    paths = PATHS[name]
    flown = with_air(library.load(PASSAGE), ROOM, ())
    sensed = replace(flown.imu, acc_noise=REAL_FLIGHTS.noise)
    found = []
    for scenario in paths.scenarios:
        planned = plan_of(library.load(scenario))
        plan = SwarmPlan(
            planned.names,
            tuple(trajectory_between(one, paths.start, paths.end) for one in planned.trajectories),
        )
        found.append(
            replace(
                flown,
                name=scenario,
                duration=paths.end - paths.start,
                imu=sensed,
                plan=plan,
                waypoints=waypoints_of(plan),
            )
        )
    return tuple(found)


def trajectory_between(trajectory: Trajectory, start: float, end: float) -> Trajectory:
    """Return the part of a trajectory from `start` to `end` [s]."""
    pieces = split_at(trajectory, np.array([start, end]))
    middle = np.cumsum(pieces.durations) - 0.5 * pieces.durations
    kept = (middle > start) & (middle < end)
    return Trajectory(pieces.durations[kept], pieces.coefficients[kept])
