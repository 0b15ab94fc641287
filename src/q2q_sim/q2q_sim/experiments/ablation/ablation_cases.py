"""Flights of the ablation, with many replicas side by side.

A case is a scenario in a wake. Its replicas are SPACING apart in one room, out of reach of each other's
downwash, each with its own noise, losses and rotors: one flight gives as many independent samples as
replicas, at a fraction of the cost of separate flights. The room `ideal` has no randomness and needs one
replica.

Two cases need other vehicles. The measured downwash is 2.3 m/s^2 at 0.5 m, and the 0.65 kg vehicle of section
5 has a margin of 0.34 m/s^2 below its 6.6 N: in that wake `table6` is flown without the limit, and
`table6_room` as `table6_measured`, by Crazyflies.
"""

from dataclasses import dataclass, replace

from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario

SPACING = 10.0
"""Between replicas [m]: ten times the reach of any downwash; 25 of them lie within +-20 m."""
COLUMNS = 5
"""Replicas in a row."""
TABLE2 = tuple(f"table2_{k}" for k in range(1, 7))
IN_PLACE = {("table6_room", "measured"): "table6_measured"}
"""Scenario flown in place of the named one in a wake."""


@dataclass(frozen=True, slots=True)
class Case:
    """Scenario and wake of a cell."""

    scenario: str
    wake: str
    """paper or measured."""

    @property
    def limited(self) -> bool:
        """Return whether section 5's bound on U1 applies."""
        return self.wake == "paper"


CASES = (
    Case("table6_room", "measured"),
    Case("stack3", "measured"),
    Case("table6", "paper"),
    Case("table6", "measured"),
    Case("table6_room", "paper"),
    *(Case(name, "paper") for name in TABLE2),
    *(Case(name, "measured") for name in TABLE2),
    Case("stack3", "paper"),
)
"""Cases, the most important first."""


def scenario_of(case: Case) -> Scenario:
    """Return the scenario of a case with its wake."""
    name = IN_PLACE.get((case.scenario, case.wake), case.scenario)
    return replace(library.load(name), wake=case.wake)


def side_by_side(scenario: Scenario, count: int) -> Scenario:
    """Return `count` replicas in one room; vehicle v of replica k is row k * vehicles + v."""
    rows = (count + COLUMNS - 1) // COLUMNS
    vehicles = []
    for k in range(count):
        aside = (SPACING * (k % COLUMNS - COLUMNS // 2), SPACING * (k // COLUMNS - rows // 2))
        vehicles += [_moved(one, f"{one.name}_{k}", aside) for one in scenario.waypoints]
    return replace(scenario, waypoints=tuple(vehicles))


def is_random(scenario: Scenario) -> bool:
    """Return whether two flights of a scenario differ."""
    vicon, disturbance, radio = scenario.vicon, scenario.disturbance, scenario.radio
    return max(vicon.pos_noise, disturbance.air_std, radio.loss, radio.jitter) > 0.0


def _moved(vehicle: VehicleWaypoints, name: str, aside: tuple[float, float]) -> VehicleWaypoints:
    points = tuple(
        replace(point, pos=(point.pos[0] + aside[0], point.pos[1] + aside[1], point.pos[2]))
        for point in vehicle.waypoints
    )
    return replace(vehicle, name=name, waypoints=points)
