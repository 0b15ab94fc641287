"""Scenario of a flight: vehicles, paths, room, downwash and parameters of the blocks.

A document (parsed YAML) is checked and converted to a Scenario here; `q2q_sim.scenarios.library` finds files.

    description: one line
    duration: 50.0            # [s]; default: to the last waypoint
    vehicle: textbook_065     # q2q_model.vehicle.constants
    firmware: stock           # its thrust per PWM: q2q_model.vehicle.thrust_map
    wake: paper               # the true downwash: none, paper, measured
    air: room.air             # in place of wake and disturbance: a shipped name, a .air file, module:Class
    air_without: [residual]   # terms of that air that are switched off
    in_air: {vehicle: crazyflie_2_0}   # keys that replace those above where the flight names another air
    attitude: firmware        # loop on board: paper (section 5.1) or firmware (the emulated stock controller)
    model: paper_law          # of the controllers: none, a shipped name, a .q2q file
    room: ideal               # q2q_sim.scenarios.settings; vicon, radio, imu, disturbance below override
    single values reading: stop_and_go      # of eq. (17): stop_and_go or free
    vehicles: {cf1: [{t: 0, pos: [0, 0, 1.5]}, ...], ...}   # without t: times as from `plan`
    plan: mine.json           # in place of vehicles: a plan file, beside this file
    overrides: {pid: {thrust_max: 6.6}}
    faults: [{kind: outlier, start: 10, duration: 0.1, vehicles: [cf1], size: 1}, ...]
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Annotated, Literal, TypeVar

from q2q_control.mpc.mpc_params import MpcParams
from q2q_control.pid.pid import PidParams
from q2q_model.documents.plain_values import from_plain
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.nearest_name import name_hint
from q2q_model.signals.values import Names
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.tunable import ParameterValue, ParamsClass, with_overrides
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, Vehicle, firmware_of, on_firmware, vehicle_by_name
from q2q_model.vehicle.thrust_map import MOTOR_THRUST, STOCK
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits, with_limits_of
from q2q_planner.offline.minimum_snap.minimum_snap import Reading
from q2q_planner.offline.minimum_snap.waypoint_document import swarm_from_document
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_planner.online.potential_field import PotentialFieldParams
from q2q_planner.online.safe.safe_replanner_params import SafeReplannerParams
from q2q_planner.playing.plan_waypoints import waypoints_of
from q2q_sim.air.air_names import check_air
from q2q_sim.air.wake_laws import wake_by_name
from q2q_sim.faults.faults import Fault, check_sizes, check_vehicles
from q2q_sim.link.radio import RadioParams
from q2q_sim.plant.disturbance import DisturbanceParams
from q2q_sim.scenarios.settings import Overrides, setting_by_name
from q2q_sim.sensors.imu import ImuParams
from q2q_sim.sensors.vicon import ViconParams

P = TypeVar("P", bound=ParamsClass)
AttitudeLoop = Literal["paper", "firmware"]

BLOCKS: dict[str, ParamsClass] = {
    "mocap_filter": MocapFilterParams(),
    "replanner": PotentialFieldParams(),
    "safe_replanner": SafeReplannerParams(),
    "pid": PidParams(),
    "mpc": MpcParams(),
}
"""Blocks whose parameters a scenario may override."""
SHORTEST, LONGEST = 0.01, 3600.0
"""Shortest flight, one tick, and longest [s]."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """Everything that is decided before a flight except its seed."""

    name: str
    description: str
    duration: float
    """[s]"""
    vehicle: Vehicle
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
        """Check the values that no part checks itself; raise ValueError with what is allowed."""
        if not (isfinite(self.duration) and SHORTEST <= self.duration <= LONGEST):
            raise ValueError(f"duration = {self.duration}: {SHORTEST} to {LONGEST} s is allowed")
        wake_by_name(self.wake)
        if self.air:
            check_air(self.air)
        elif self.air_without:
            raise ValueError(f"air_without = {', '.join(self.air_without)}: name an air too")
        for vehicle in self.waypoints:
            for k, waypoint in enumerate(vehicle.waypoints):
                if waypoint.pos[2] < 0.0:
                    where = f"{vehicle.name}, waypoint {k}: z = {waypoint.pos[2]} m"
                    raise ValueError(f"{where}: z is up, and the ground is at 0")
        _check_latency(self)
        check_vehicles(self.faults, self.names)
        for block, values in self.overrides.items():
            overridden(BLOCKS[block], values, block)

    @property
    def names(self) -> Names:
        """Return the vehicles' names."""
        return tuple(vehicle.name for vehicle in self.waypoints)


@dataclass(frozen=True, slots=True)
class _Document:
    """Keys of a document and their defaults."""

    description: object = ""
    duration: float | None = None
    vehicle: str = DEFAULT_VEHICLE
    firmware: str = STOCK
    wake: str = "none"
    air: str = ""
    air_without: Annotated[Names, "a list of names"] = ()
    in_air: Mapping[str, object] | None = None
    attitude: AttitudeLoop = "paper"
    model: str = "none"
    room: str = "ideal"
    reading: Reading = "stop_and_go"
    vehicles: object = None
    plan: Annotated[str, "the path of a plan file"] = ""
    overrides: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    vicon: Mapping[str, object] = field(default_factory=dict)
    radio: Mapping[str, object] = field(default_factory=dict)
    imu: Mapping[str, object] = field(default_factory=dict)
    disturbance: Mapping[str, object] = field(default_factory=dict)
    faults: tuple[Fault, ...] = ()


def scenario_from_document(name: str, document: object, plan: SwarmPlan | None = None) -> Scenario:
    """Return the scenario of a parsed YAML document; `plan` is the content of its plan file.

    Only `vehicles` or `plan` is required: a file of waypoints alone is a scenario.

    Raises:
        ValueError: with the keys and values that are not allowed, and what is.
    """
    given = from_plain(_Document, document, "")
    room = setting_by_name(given.room)
    vehicle = vehicle_by_name(given.vehicle, given.firmware)
    waypoints = _waypoints(given, with_limits_of(FlightLimits(), vehicle), plan)
    last = max(float(one.times[-1]) for one in waypoints)
    check_sizes(given.faults)
    return Scenario(
        name=name,
        description=str(given.description),
        duration=last if given.duration is None else given.duration,
        vehicle=vehicle,
        waypoints=waypoints,
        plan=plan,
        reading=given.reading,
        wake=given.wake,
        air=given.air,
        air_without=given.air_without,
        in_air=scenario_from_document(name, document_in_air(document), plan) if given.in_air else None,
        attitude=given.attitude,
        model=given.model,
        vicon=overridden(room.vicon, given.vicon, "vicon"),
        radio=overridden(room.radio, given.radio, "radio"),
        imu=overridden(room.imu, given.imu, "imu"),
        disturbance=overridden(room.disturbance, given.disturbance, "disturbance"),
        faults=given.faults,
        overrides=_merged(room.overrides, given.overrides),
    )


def document_in_air(document: object) -> dict[str, object]:
    """Return a scenario's document with the keys of its `in_air` in place of its own."""
    entries = from_plain(dict[str, object], document, "")
    in_air = from_plain(dict[str, object], entries.pop("in_air", {}), "in_air")
    return entries | in_air


def with_firmware(scenario: Scenario, firmware: str) -> Scenario:
    """Return the scenario with another firmware; an empty name keeps the present one.

    Raises:
        ValueError: the vehicle does not have this firmware.
    """
    if not firmware:
        return scenario
    return replace(scenario, vehicle=on_firmware(scenario.vehicle, firmware))


def with_air(scenario: Scenario, air: str, off: tuple[str, ...]) -> Scenario:
    """Return the scenario in another air, and with terms of its air switched off; empty keeps its own.

    In an air that is neither `none` nor the scenario's own wake, its `in_air` is flown if there is one.

    Raises:
        ValueError: an unknown air, or terms without an air.
    """
    if not air and not off:
        return scenario
    other = air not in ("", "none", scenario.wake)
    flown = scenario.in_air if other and scenario.in_air is not None else scenario
    return replace(flown, air=air or flown.air, air_without=off or flown.air_without)


def with_choices(scenario: Scenario, vehicle: str, wake: str) -> Scenario:
    """Return the scenario with another vehicle and another wake; empty names keep its own.

    The vehicle is on the scenario's firmware if it has that, else on the stock one. A wake replaces the
    scenario's air too.

    Raises:
        ValueError: an unknown vehicle or wake.
    """
    firmware = firmware_of(scenario.vehicle)
    if firmware not in MOTOR_THRUST.get(vehicle, ()):
        firmware = STOCK
    chosen = vehicle_by_name(vehicle, firmware) if vehicle else scenario.vehicle
    in_air = scenario.in_air if scenario.in_air is None else with_choices(scenario.in_air, vehicle, wake)
    if not wake:
        return replace(scenario, vehicle=chosen, in_air=in_air)
    return replace(scenario, vehicle=chosen, in_air=in_air, wake=wake, air="", air_without=())


def _waypoints(
    given: _Document, limits: FlightLimits, plan: SwarmPlan | None
) -> tuple[VehicleWaypoints, ...]:
    if plan is None:
        return swarm_from_document({"vehicles": given.vehicles}, limits, given.reading)
    if given.vehicles is not None:
        raise ValueError("vehicles and plan are both given: a plan names its vehicles; leave one out")
    return waypoints_of(plan)


def block_params(block: str, default: P, overrides: Overrides) -> P:
    """Return a block's parameters with a scenario's overrides."""
    return overridden(default, overrides.get(block, {}), block)


def overridden(params: P, values: Mapping[str, object], where: str) -> P:
    """Return `params` with values from a document.

    Raises:
        ValueError: an unknown parameter, a value of another type, or one out of bounds.
    """
    return with_overrides(params, _values(params, values, where))


def _values(params: ParamsClass, values: Mapping[str, object], where: str) -> dict[str, ParameterValue]:
    """Return a document's values as parameters; `with_overrides` refuses unknown names."""
    return {
        key: _value(value, getattr(params, key, value), f"{where}.{key}") for key, value in values.items()
    }


def _value(value: object, default: object, where: str) -> ParameterValue:
    """Return a document's value in the type of a parameter: an integer as float, a list as tuple."""
    if isinstance(default, tuple | list) and isinstance(value, list | tuple):
        return tuple(_number(one, where) for one in value)
    if isinstance(default, float):
        return _number(value, where)
    if isinstance(value, bool | int | str) and type(value) is type(default):
        return value
    raise ValueError(f"{where} = {value!r}: a {type(default).__name__} is expected")


def _merged(room: Overrides, own: Mapping[str, Mapping[str, object]]) -> Overrides:
    for block in own:
        if block not in BLOCKS:
            raise ValueError(f"overrides: unknown block {block!r}; {name_hint(block, BLOCKS)}")
    blocks = {block: _values(BLOCKS[block], values, f"overrides.{block}") for block, values in own.items()}
    return {block: {**room.get(block, {}), **blocks.get(block, {})} for block in sorted({*room, *blocks})}


def _check_latency(scenario: Scenario) -> None:
    camera, radio = scenario.vicon.latency, scenario.radio.latency
    try:
        replace(scenario.radio, latency=camera + radio)
    except ValueError as refusal:
        raise ValueError(
            f"vicon.latency {camera} s and radio.latency {radio} s together: {refusal}"
        ) from refusal


def _number(value: object, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{where} = {value!r}: a number is expected")  # noqa: TRY004  a bad document, not a bad call
    return float(value)
