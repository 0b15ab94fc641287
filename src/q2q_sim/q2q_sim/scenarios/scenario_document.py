"""Document of a scenario (parsed YAML), checked and converted to a Scenario.

`q2q_sim.scenarios.library` finds files.

    description: one line
    duration: 50.0            # [s]; default: to the last waypoint
    vehicle: textbook_065     # q2q_model.vehicle.constants
    firmware: stock           # its thrust per PWM: q2q_model.vehicle.thrust_map
    wake: paper               # the true downwash: none, paper, measured
    air: room.air             # in place of wake and disturbance: a shipped name, a .air file, module:Class
    air_without: [residual]   # terms of that air that are switched off
    in_air: {vehicle: crazyflie_2_0}   # keys that replace the others where the flight names another air
    attitude: firmware        # loop on board: paper (section 5.1) or firmware (the emulated stock controller)
    model: paper_law          # of the controllers: none, a shipped name, a .q2q file
    room: ideal               # q2q_sim.scenarios.room_profiles; vicon, radio, imu, disturbance below override
    reading: stop_and_go      # of eq. (17): stop_and_go or free
    vehicles: {cf1: [{t: 0, pos: [0, 0, 1.5]}, ...], ...}   # without t: times as from `plan`
    plan: mine.json           # in place of vehicles: a plan file, next to this file
    overrides: {pid: {thrust_max: 6.6}}
    faults: [{kind: outlier, start: 10, duration: 0.1, vehicles: [cf1], size: 1}, ...]
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from datetime import date
from typing import Annotated

from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.shown_value import shown_value
from q2q_model.signals.values import Names
from q2q_model.trajectory.polynomials import SwarmPlan
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, vehicle_by_name
from q2q_model.vehicle.thrust_map import STOCK
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits, with_limits_of
from q2q_planner.offline.minimum_snap.minimum_snap import Reading
from q2q_planner.offline.minimum_snap.waypoint_document import swarm_from_document
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_planner.plan_playback.plan_waypoints import waypoints_of
from q2q_sim.faults.faults import Fault, check_sizes
from q2q_sim.scenarios.block_overrides import merge_overrides, override_params
from q2q_sim.scenarios.room_profiles import profile_by_name
from q2q_sim.scenarios.scenario import AttitudeLoop, Scenario

MOTIONS = frozenset({"vehicles", "plan"})
"""Keys of which a document has one: where the vehicles fly."""


@dataclass(frozen=True, slots=True)
class _Document:
    """Keys of a document and their defaults."""

    description: object = ""
    duration: float | None = None
    vehicle: Annotated[str, "the name of one type, that of all vehicles"] = DEFAULT_VEHICLE
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


def no_plan_file(named: str) -> SwarmPlan:
    """Raise ValueError: a document without a file has no plan next to it."""
    raise ValueError(f"plan = {named!r}: only a scenario file can name a plan, which lies next to it")


def scenario_from_document(
    name: str, document: object, load_plan: Callable[[str], SwarmPlan] = no_plan_file
) -> Scenario:
    """Return the scenario of a parsed YAML document; `load_plan` returns the plan that it names.

    Only `vehicles` or `plan` is required: a file of waypoints alone is a scenario.

    Raises:
        ValueError: with the keys and values that are not allowed, and what is.
    """
    given = from_plain(_Document, document, "")
    room = profile_by_name(given.room)
    vehicle = vehicle_by_name(given.vehicle, given.firmware)
    plan = load_plan(given.plan) if given.plan else None
    waypoints = _waypoints(given, with_limits_of(FlightLimits(), vehicle), plan)
    last = max(float(one.times[-1]) for one in waypoints)
    check_sizes(given.faults)
    own = Scenario(
        name=name,
        description=_description(given.description),
        duration=last if given.duration is None else given.duration,
        vehicle=vehicle,
        waypoints=waypoints,
        plan=plan,
        reading=given.reading,
        wake=given.wake,
        air=given.air,
        air_without=given.air_without,
        attitude=given.attitude,
        model=given.model,
        vicon=override_params(room.vicon, given.vicon, "vicon"),
        radio=override_params(room.radio, given.radio, "radio"),
        imu=override_params(room.imu, given.imu, "imu"),
        disturbance=override_params(room.disturbance, given.disturbance, "disturbance"),
        faults=given.faults,
        overrides=merge_overrides(room.overrides, given.overrides),
    )
    if not given.in_air:
        return own
    in_air = scenario_from_document(name, document_in_air(document), load_plan)
    return replace(own, in_air=in_air, as_written=own)


def _description(given: object) -> str:
    """Return a description: a number or a date in YAML is one, and a key without a value is empty."""
    if given is not None and not isinstance(given, str | int | float | date):
        raise ValueError(f"description = {shown_value(given)}; must be text")
    return "" if given is None else str(given)


def document_in_air(document: object) -> dict[str, object]:
    """Return a scenario's document with the keys of its `in_air` in place of its own.

    Vehicles replace a plan, and a plan vehicles.
    """
    entries = from_plain(dict[str, object], document, "")
    in_air = from_plain(dict[str, object], entries.pop("in_air", {}), "in_air")
    replaced = MOTIONS if MOTIONS & in_air.keys() else frozenset()
    return {key: value for key, value in entries.items() if key not in replaced} | in_air


def _waypoints(
    given: _Document, limits: FlightLimits, plan: SwarmPlan | None
) -> tuple[VehicleWaypoints, ...]:
    if plan is None:
        return swarm_from_document({"vehicles": given.vehicles}, limits, given.reading)
    if given.vehicles is not None:
        raise ValueError("vehicles and plan are both given: a plan names its vehicles; leave one out")
    return waypoints_of(plan)
