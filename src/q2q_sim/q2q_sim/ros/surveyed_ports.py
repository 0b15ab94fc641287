"""Topics and services of a node over all its start configurations, each with the parameters it requires."""

from q2q_sim.ros.node_configurations import VEHICLE, Configuration
from q2q_sim.ros.required_parameters import required_parameters
from q2q_sim.ros.stand_in import RecordedPort, StandInNode

ANY_VEHICLE = "<name>"
"""Any vehicle in the names of topics."""


def surveyed_ports(built: list[StandInNode], chosen: list[Configuration]) -> list[tuple[RecordedPort, str]]:
    """Return every port once, with the parameters that it requires."""
    found = [[_of_any_vehicle(port) for port in node.ports] for node in built]
    return list(required_parameters(found, chosen).items())


def _of_any_vehicle(port: RecordedPort) -> RecordedPort:
    if not port.name.startswith(f"{VEHICLE}/"):
        return port
    return RecordedPort(
        port.direction, f"{ANY_VEHICLE}/{port.name.removeprefix(VEHICLE + '/')}", port.kind, port.quality
    )
