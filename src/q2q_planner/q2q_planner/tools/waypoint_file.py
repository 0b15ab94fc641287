"""Reader of a YAML file of waypoints; an error is one line with the place in the file."""

from pathlib import Path

from q2q_model.documents.yaml_text import load_yaml
from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits
from q2q_planner.offline.minimum_snap.minimum_snap import Reading
from q2q_planner.offline.minimum_snap.waypoint_document import swarm_from_document
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints


def read_waypoints(path: Path, limits: FlightLimits, reading: Reading) -> tuple[VehicleWaypoints, ...]:
    """Return the waypoints of a file, timed within `limits` if it has no times.

    Raises:
        ValueError: naming the file, and vehicle, waypoint and bound or the place in the file.
    """
    document = load_yaml(path)
    try:
        return swarm_from_document(document, limits, reading)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
