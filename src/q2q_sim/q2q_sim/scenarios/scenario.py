"""Scenario of a flight: vehicles, paths, room, downwash and parameters of the blocks."""

from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Literal

from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.signals.values import Names
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.vehicle.constants import Vehicle
from q2q_planner.offline.minimum_snap.minimum_snap import Reading
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_sim.air.air_names import check_air
from q2q_sim.air.wake_laws import wake_by_name
from q2q_sim.faults.faults import Fault, check_vehicles
from q2q_sim.link.radio import RadioParams
from q2q_sim.plant.disturbance import DisturbanceParams
from q2q_sim.scenarios.block_overrides import block_params, check_overrides
from q2q_sim.scenarios.room_profiles import Overrides
from q2q_sim.scenarios.scenario_limits import LONGEST, SHORTEST
from q2q_sim.sensors.imu import ImuParams
from q2q_sim.sensors.vicon_params import ViconParams

AttitudeLoop = Literal["paper", "firmware"]

GROUND_ROUNDING = 1e-6
"""Depth of a waypoint below the ground that is taken as rounding [m]: that of a polynomial's end within the
bounds of `q2q_planner.offline.minimum_snap.waypoints`."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """Everything that is decided before a flight except its seed."""

    name: str
    description: str
    duration: float
    """[s]"""
    vehicle: Vehicle
    """Type of all vehicles."""
    waypoints: tuple[VehicleWaypoints, ...]
    """One for each vehicle."""
    plan: SwarmPlan | None = None
    """Flown unchanged; None to plan through the waypoints."""
    reading: Reading = "stop_and_go"
    wake: str = "none"
    air: str = ""
    """Air in place of wake and disturbance; empty keeps them."""
    air_without: tuple[str, ...] = ()
    """Terms of the air that are switched off."""
    in_air: "Scenario | None" = None
    """Flown in its place where the flight names another air."""
    as_written: "Scenario | None" = field(default=None, compare=False)
    """As its document gives it, kept if it has an `in_air`: what differs from it was changed since."""
    attitude: AttitudeLoop = "paper"
    """Loop that executes commands on board: section 5.1, or the emulated stock controller."""
    model: str = "none"
    """Interaction model of the controllers."""
    vicon: ViconParams = field(default_factory=ViconParams)
    radio: RadioParams = field(default_factory=RadioParams)
    imu: ImuParams = field(default_factory=ImuParams)
    disturbance: DisturbanceParams = field(default_factory=DisturbanceParams)
    faults: tuple[Fault, ...] = ()
    overrides: Overrides = field(default_factory=dict)
    """Parameters of blocks that differ from their defaults: {block: {parameter: value}}."""

    def __post_init__(self) -> None:
        """Check the values that no part checks itself; say what is allowed.

        Raises:
            TypeError: the duration is no number.
            ValueError: a value is not allowed.
        """
        if isinstance(self.duration, bool) or not isinstance(self.duration, Real):
            raise TypeError(f"duration = {self.duration!r}; must be a number of seconds")
        if not SHORTEST <= self.duration <= LONGEST:
            raise ValueError(f"duration = {self.duration}; must be in [{SHORTEST}, {LONGEST}] s")
        wake_by_name(self.wake)
        if self.air:
            check_air(self.air)
        elif self.air_without:
            raise ValueError(f"air_without = {', '.join(self.air_without)}: also name an air")
        _check_latency(self)
        check_vehicles(self.faults, self.names)
        check_overrides(self.overrides)
        _check_waypoints(self)

    @property
    def names(self) -> Names:
        """Return the vehicles' names."""
        return tuple(vehicle.name for vehicle in self.waypoints)


def _check_waypoints(scenario: Scenario) -> None:
    """Raise ValueError for a waypoint below the ground, or where the mocap filter accepts no position."""
    pos_max = block_params("mocap_filter", MocapFilterParams(), scenario.overrides).pos_max
    for vehicle in scenario.waypoints:
        for k, waypoint in enumerate(vehicle.waypoints):
            where = f"{vehicle.name}, waypoint {k}"
            if waypoint.pos[2] < -GROUND_ROUNDING:
                raise ValueError(
                    f"{where}: z = {waypoint.pos[2]} m; must be at least 0 (z is up, the ground at 0)"
                )
            axis, value = max(zip("xyz", waypoint.pos, strict=True), key=lambda one: abs(one[1]))
            if abs(value) > pos_max:
                raise ValueError(
                    f"{where}: {axis} = {value:g} m; must be within {pos_max:g} m for mocap_filter: give "
                    "metres, or set overrides.mocap_filter.pos_max"
                )


def _check_latency(scenario: Scenario) -> None:
    camera, radio = scenario.vicon.latency, scenario.radio.latency
    try:
        replace(scenario.radio, latency=camera + radio)
    except ValueError as refusal:
        raise ValueError(
            f"vicon.latency {camera} s and radio.latency {radio} s together: {refusal}"
        ) from refusal
