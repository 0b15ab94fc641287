"""Vehicles of Crazyswarm2's server in a licence: those of a `crazyflies.yaml`, or a row of stock ones.

The server sets firmware parameters when it connects, and logs `pose` and `status` of every vehicle. Both are
read at three levels of the file, of which the last wins: `all`, the robot's type, the robot. Without a file,
they are those of the file that Crazyswarm2 ships (crazyflie/config/crazyflies.yaml, commit f6154e2).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from q2q_control.radio.crazyflies_file import check_connections, crazyflies_from_document, params_set
from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.yaml_text import load_yaml
from q2q_model.signals.values import Three

STOCK_PARAMETERS: Mapping[str, float] = {
    "commander.enHighLevel": 1,
    "stabilizer.estimator": 2,
    "stabilizer.controller": 2,
    "locSrv.extPosStdDev": 1e-3,
    "locSrv.extQuatStdDev": 0.5e-1,
}
STOCK_POSE_HZ, STOCK_STATUS_HZ = 10, 1


@dataclass(frozen=True, slots=True)
class ServedVehicle:
    """Vehicle of the server."""

    name: str
    uri: str
    initial: Three
    """Position that the server believes it starts at [m], world; int if the file has whole numbers only."""
    parameters: tuple[tuple[str, float], ...] = tuple(STOCK_PARAMETERS.items())
    """Firmware parameters that the server sets, by name."""
    pose_hz: int = STOCK_POSE_HZ
    """0: `pose` is not logged."""
    status_hz: int = STOCK_STATUS_HZ

    @property
    def start(self) -> Three:
        """Return where it stands unless set otherwise: x, y [m], yaw [rad]."""
        x, y, _ = self.initial
        return float(x), float(y), 0.0


@dataclass(frozen=True, slots=True)
class _Topic:
    frequency: int = 0


@dataclass(frozen=True, slots=True)
class _Logging:
    """Entry `firmware_logging`."""

    enabled: bool | None = None
    default_topics: Mapping[str, _Topic] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Level:
    """Entry of all, of a type or of a robot."""

    firmware_logging: _Logging | None = None
    type: object = None
    initial_position: object = None


@dataclass(frozen=True, slots=True)
class _File:
    robots: Mapping[str, _Level]
    robot_types: Mapping[str, _Level | None] = field(default_factory=dict)
    all: _Level | None = None


def vehicles_from_file(path: Path) -> tuple[ServedVehicle, ...]:
    """Return the enabled vehicles of a `crazyflies.yaml`, sorted by name, as the program sees them.

    Raises:
        ValueError: the file cannot be read, or is wrong.
    """
    document = load_yaml(path)
    check_connections(document)
    file = from_plain(_File, document, "crazyflies.yaml", extra=True)
    found = [
        ServedVehicle(
            name=one.name,
            uri=one.uri,
            initial=_initial(one.start, file.robots[one.name].initial_position),
            parameters=tuple(params_set(document, one.name, by_type=True).items()),
            pose_hz=_frequency(file, one.name, "pose"),
            status_hz=_frequency(file, one.name, "status"),
        )
        for one in crazyflies_from_document(document)
    ]
    return tuple(sorted(found, key=lambda one: one.name))


def stock_vehicles(uris: Sequence[str], starts: Sequence[Three]) -> tuple[ServedVehicle, ...]:
    """Return vehicles named by the last byte of their addresses (cf1, cf231), sorted by name."""
    found = [
        ServedVehicle(f"cf{int(uri[-2:], 16)}", uri, (x, y, 0.0))
        for uri, (x, y, _) in zip(uris, starts, strict=True)
    ]
    return tuple(sorted(found, key=lambda one: one.name))


def _initial(start: Three, given: object) -> Three:
    """Return an initial position [m] with the numbers that ROS declares: int if the file has only such."""
    x, y, z = start
    whole = isinstance(given, list) and all(isinstance(one, int) for one in given)
    return (int(x), int(y), int(z)) if whole else start


def _frequency(file: _File, name: str, topic: str) -> int:
    """Return the frequency of a default topic of a vehicle [Hz]; 0 if it is not logged."""
    robot = file.robots[name]
    levels = (file.all, file.robot_types.get(str(robot.type)), robot)
    logging = [one.firmware_logging for one in levels if one is not None and one.firmware_logging is not None]
    enabled = next((one.enabled for one in reversed(logging) if one.enabled is not None), False)
    set_by = (one.default_topics[topic].frequency for one in reversed(logging) if topic in one.default_topics)
    return next(set_by, 0) if enabled else 0
