"""Options of `plan` that say what flies the waypoints, and how; without them the waypoint file says it."""

from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager

from q2q_model.tunable import OutOfBoundsError
from q2q_model.vehicle.constants import Vehicle, vehicle_by_name
from q2q_model.vehicle.thrust_map import MOTOR_THRUST, STOCK
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits, with_limits_of
from q2q_planner.offline.minimum_snap.waypoint_document import WaypointDocument
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints
from q2q_planner.tools.waypoint_file import naming_file, read_document, timed_waypoints


def read_swarm(asked: Namespace) -> tuple[Namespace, tuple[VehicleWaypoints, ...]]:
    """Return the options as flown (`vehicle` is a Vehicle, `reading` is given), and the timed waypoints.

    Raises:
        ValueError: naming the file, and the key, or vehicle, waypoint and bound.
    """
    document = read_document(asked.waypoints)
    with naming_file(asked.waypoints):
        vehicle = _vehicle_of(asked.vehicle, document)
    reading = asked.reading or document.reading
    flown = Namespace(**vars(asked) | {"vehicle": vehicle, "reading": reading})
    with naming_options():
        limits = with_limits_of(FlightLimits(asked.speed, asked.acceleration, asked.tilt), vehicle)
    return flown, timed_waypoints(asked.waypoints, document, limits, reading)


@contextmanager
def naming_options() -> Iterator[None]:
    """Name, in an error of a parameter that is out of bounds, the option of the same name."""
    try:
        yield
    except OutOfBoundsError as wrong:
        raise ValueError(f"--{wrong.name.replace('_', '-')} = {wrong.rest}") from wrong


def _vehicle_of(name: str | None, document: WaypointDocument) -> Vehicle:
    """Return the document's vehicle, or the one named, which is on the document's firmware if it has that."""
    if name is None:
        return vehicle_by_name(document.vehicle, document.firmware)
    known = MOTOR_THRUST.get(name, {})
    return vehicle_by_name(name, document.firmware if document.firmware in known else STOCK)
