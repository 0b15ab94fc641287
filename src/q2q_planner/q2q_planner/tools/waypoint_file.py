"""Reader of a YAML file of waypoints; an error is one line with the place in the file."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from q2q_model.documents.yaml_text import load_yaml
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits
from q2q_planner.offline.minimum_snap.minimum_snap import Reading
from q2q_planner.offline.minimum_snap.waypoint_document import (
    WaypointDocument,
    checked_document,
    timed_swarm,
)
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints


def read_waypoints(path: Path, limits: FlightLimits, reading: Reading) -> tuple[VehicleWaypoints, ...]:
    """Return the waypoints of a file, timed within `limits` if it has no times.

    Raises:
        ValueError: naming the file, and vehicle, waypoint and bound or the place in the file.
    """
    return timed_waypoints(path, read_document(path), limits, reading)


def read_document(path: Path) -> WaypointDocument:
    """Return the document of a file; raise ValueError naming the file, the place and what is expected."""
    plain = load_yaml(path)
    with naming_file(path):
        return checked_document(plain)


def timed_waypoints(
    path: Path, document: WaypointDocument, limits: FlightLimits, reading: Reading
) -> tuple[VehicleWaypoints, ...]:
    """Return the waypoints of a file's document; as `read_waypoints`."""
    with naming_file(path):
        return timed_swarm(document, limits, reading)


@contextmanager
def naming_file(path: Path) -> Iterator[None]:
    """Put the path of the file before the message of a ValueError."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
