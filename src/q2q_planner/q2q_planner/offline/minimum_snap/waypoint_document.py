"""Waypoints of a parsed YAML or JSON document; a vehicle whose waypoints have no times gets them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isnan, nan, tau
from typing import Annotated

from q2q_model.documents.plain_values import from_plain
from q2q_model.signals.values import Three
from q2q_model.signals.vehicle_name import check_vehicle_name
from q2q_model.vehicle.constants import DEFAULT_VEHICLE
from q2q_model.vehicle.thrust_map import STOCK
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits, allocate_times
from q2q_planner.offline.minimum_snap.minimum_snap import Reading
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint, check_swarm

ROUNDED = 1e-3
"""Excess of a full turn that is one written with few digits [rad]: 6.2832."""


@dataclass(frozen=True, slots=True)
class WaypointDocument:
    """Waypoints, and what flies them; further keys of a document are those of a scenario."""

    vehicles: Annotated[
        Mapping[str, Annotated[tuple[object, ...], "a list of waypoints"]],
        "{name: waypoints}, such as {cf1: [{t: 0, pos: [0, 0, 1]}, {t: 5, pos: [1, 0, 1], yaw: 0}]}",
    ]
    vehicle: str = DEFAULT_VEHICLE
    """Name in `q2q_model.vehicle.constants`."""
    firmware: str = STOCK
    """Its thrust per PWM, of `q2q_model.vehicle.thrust_map`."""
    reading: Reading = "stop_and_go"
    """Of eq. (17)."""


@dataclass(frozen=True, slots=True)
class _Row:
    """Waypoint of a document."""

    pos: Annotated[Three, "[x, y, z] in metres"]
    t: float = nan
    """NaN if it is not given."""
    yaw: float = 0.0


def swarm_from_document(
    document: object, limits: FlightLimits, reading: Reading = "stop_and_go"
) -> tuple[VehicleWaypoints, ...]:
    """Return the waypoints of a document, timed within `limits` where a vehicle has no times.

    Raises:
        ValueError: naming the vehicle, the waypoint and what is expected there.
    """
    return timed_swarm(checked_document(document), limits, reading)


def checked_document(document: object) -> WaypointDocument:
    """Return a parsed document; raise ValueError naming the key and what is expected there."""
    return from_plain(WaypointDocument, document, "the file", extra=True)


def timed_swarm(
    document: WaypointDocument, limits: FlightLimits, reading: Reading
) -> tuple[VehicleWaypoints, ...]:
    """Return the waypoints of a checked document; as `swarm_from_document`."""
    swarm = tuple(_vehicle(name, rows, limits, reading) for name, rows in document.vehicles.items())
    check_swarm(swarm)
    return swarm


def _vehicle(name: str, rows: tuple[object, ...], limits: FlightLimits, reading: Reading) -> VehicleWaypoints:
    check_vehicle_name(name)
    read = [from_plain(_Row, row, f"{name}, waypoint {index}") for index, row in enumerate(rows)]
    _check_turns(name, read)
    missing = [index for index, row in enumerate(read) if isnan(row.t)]
    if 0 < len(missing) < len(read):
        raise ValueError(f"{name}, waypoint {missing[0]}: t is missing: give all waypoints a t [s], or none")
    times = [float(index) for index in missing] or [row.t for row in read]
    made = VehicleWaypoints(
        name, tuple(Waypoint(t, row.pos, row.yaw) for t, row in zip(times, read, strict=True))
    )
    return allocate_times(name, made.waypoints, limits, reading) if missing else made


def _check_turns(name: str, rows: Sequence[_Row]) -> None:
    """Raise ValueError where yaw turns by more than a full turn from a waypoint to the next: degrees do."""
    for index, (before, after) in enumerate(pairwise(rows), start=1):
        if abs(after.yaw - before.yaw) > tau + ROUNDED:
            raise ValueError(
                f"{name}, waypoint {index}: yaw {after.yaw:g} rad is {abs(after.yaw - before.yaw):g} rad "
                "from the previous one, maximum one turn (6.283): give radians, or waypoints in between"
            )
