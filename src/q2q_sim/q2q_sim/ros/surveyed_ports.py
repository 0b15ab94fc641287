"""Topics and services of a node over all its start configurations, each with the parameters it requires."""

from q2q_model.tunable import ParameterValue
from q2q_sim.ros.node_configurations import VEHICLE, Configuration
from q2q_sim.ros.stand_in import RecordedPort, StandInNode

ANY_VEHICLE = "<name>"
"""Any vehicle in the names of topics."""


def surveyed_ports(built: list[StandInNode], chosen: list[Configuration]) -> list[tuple[RecordedPort, str]]:
    """Return every port once, with the parameters that it requires."""
    owners: dict[RecordedPort, list[Configuration]] = {}
    for node, configuration in zip(built, chosen, strict=True):
        for port in dict.fromkeys(_of_any_vehicle(port) for port in node.ports):
            owners.setdefault(port, []).append(configuration)
    return [
        (port, "" if len(having) == len(chosen) else _distinction(having, chosen))
        for port, having in owners.items()
    ]


def _distinction(having: list[Configuration], chosen: list[Configuration]) -> str:
    """Return the parameters shared by these configurations and no other; empty if there is no other."""
    lacking = [configuration for configuration in chosen if configuration not in having]
    if not lacking:
        return ""
    shared = {key: value for key, value in having[0].items() if all(one.get(key) == value for one in having)}
    distinct = {key: value for key, value in shared.items() if all(one.get(key) != value for one in lacking)}
    return ", ".join(f"`{key}`: {_plain(value)}" for key, value in distinct.items())


def _plain(value: ParameterValue) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _of_any_vehicle(port: RecordedPort) -> RecordedPort:
    if not port.name.startswith(f"{VEHICLE}/"):
        return port
    return RecordedPort(
        port.direction, f"{ANY_VEHICLE}/{port.name.removeprefix(VEHICLE + '/')}", port.kind, port.quality
    )
