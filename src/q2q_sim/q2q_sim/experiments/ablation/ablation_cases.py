"""Flights of the ablation: paths, the air they are flown in, and the family of flights behind the models.

A plant is an air learned from recorded flights of one family; the models that controllers are given in it are
learned from flights of the other family (q2q_sim.experiments.ablation.learned_models). Air and model share
neither a flight nor a form: the air has a table, and a model a Gaussian jet.

All paths are flown by the vehicles, in the room, and with the gains of `table6_room` in an air. Draws are
SPACING apart in one room, out of reach of each other's downwash, each with its own noise, losses, gusts,
residual and vehicles: one flight gives as many independent samples as draws.
"""

from dataclasses import dataclass, replace

from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_sim.air.air_names import ROOM
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario, with_air

SPACING = 10.0
"""Between draws [m]: ten times the reach of any downwash; 25 of them lie within +-20 m."""
COLUMNS = 5
"""Draws in a row."""
PASSAGE = "table6_room"


@dataclass(frozen=True, slots=True)
class Plant:
    """Air of a case, and the flights that its controllers' models are learned from."""

    air: str
    """A shipped air that was learned from flights (q2q_sim.air.air_names)."""
    family: str
    """Recorded flights behind the air: the start of their names."""
    models: str
    """Recorded flights behind the models."""


SHIPPED = Plant(ROOM, "dc21", "dc19")


@dataclass(frozen=True, slots=True)
class Case:
    """Paths and plant of a table."""

    scenario: str
    plant: Plant = SHIPPED

    @property
    def title(self) -> str:
        """Return the heading of the case's table."""
        return f"{self.scenario}, air {self.plant.air}"


CASES = (Case(PASSAGE), Case("stack3"))
"""Cases, the most important first."""


def scenario_of(case: Case) -> Scenario:
    """Return the scenario of a case; the air of its flight is given to the closed loop."""
    flown = with_air(library.load(PASSAGE), ROOM, ())
    paths = library.load(case.scenario)
    return replace(
        flown,
        name=paths.name,
        duration=paths.duration,
        reading=paths.reading,
        waypoints=paths.waypoints,
    )


def side_by_side(scenario: Scenario, count: int) -> Scenario:
    """Return `count` draws in one room; vehicle v of draw k is row k * vehicles + v."""
    rows = (count + COLUMNS - 1) // COLUMNS
    vehicles = []
    for k in range(count):
        aside = (SPACING * (k % COLUMNS - COLUMNS // 2), SPACING * (k // COLUMNS - rows // 2))
        vehicles += [_moved(one, f"{one.name}_{k}", aside) for one in scenario.waypoints]
    return replace(scenario, waypoints=tuple(vehicles))


def _moved(vehicle: VehicleWaypoints, name: str, aside: tuple[float, float]) -> VehicleWaypoints:
    points = tuple(
        replace(point, pos=(point.pos[0] + aside[0], point.pos[1] + aside[1], point.pos[2]))
        for point in vehicle.waypoints
    )
    return replace(vehicle, name=name, waypoints=points)
