"""Vehicles of Crazyswarm2's `crazyflies.yaml`.

    robots:
      cf1: {enabled: true, uri: radio://0/80/2M/E7E7E7E701, initial_position: [0, 0, 0], type: cf21}

Of other keys, only `firmware_params` is read, whose values are set by the server, or by the node `radio` as
the C++ server does. A robot with `connection: none`, its own or its type's, is skipped: it is tracked by
motion capture but not flown. Crazyswarm2's servers read that of the type only: check_connections refuses a
robot's own where they fly.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.yaml_text import load_yaml
from q2q_model.signals.values import Names, check_unique
from q2q_model.signals.vehicle_name import check_vehicle_name
from q2q_model.vehicle.vehicle_uri import canonical_uri

Position = tuple[float, float, float]
CRAZYFLIE = "crazyflie"
"""Connection of the robots that are flown, and of a type that has none."""
URI = "a URI like radio://0/80/2M/E7E7E7E701"
SCHEMES = tuple(f"{driver}://" for driver in ("radio", "usb", "udp", "tcp", "prrt"))
"""Beginnings of the URIs that cflib opens unless it is asked for more."""


@dataclass(frozen=True, slots=True)
class Crazyflie:
    """Enabled vehicle."""

    name: str
    uri: str
    start: Position
    """Initial position [m], world."""
    firmware_params: Mapping[str, float] = field(default_factory=dict)
    """Firmware parameters to set, `group.name` -> value."""


def crazyflies_at(names: Names, uris: Sequence[str]) -> tuple[Crazyflie, ...]:
    """Return vehicles given by name and URI instead of a file.

    Raises:
        ValueError: there are none; a name is none of a topic or used twice; a URI is wrong or used twice.
    """
    if not names:
        raise ValueError("no vehicles: set crazyflies:=FILE, or vehicles and uris")
    made = tuple(Crazyflie(name, uri, (0.0, 0.0, 0.0)) for name, uri in zip(names, uris, strict=True))
    _check(made)
    return made


@dataclass(frozen=True, slots=True)
class _Robot:
    """Entry of a robot, of a type of robots, or of all."""

    enabled: bool = False
    type: object = None
    connection: object = None
    uri: Annotated[str, URI] = ""
    initial_position: Annotated[Position, "a list of three numbers [m]"] = (0.0, 0.0, 0.0)
    firmware_params: Mapping[str, Mapping[str, object] | None] | None = None


@dataclass(frozen=True, slots=True)
class _Fleet:
    """Content of a `crazyflies.yaml`."""

    robots: Mapping[str, _Robot]
    robot_types: Mapping[str, _Robot | None] = field(default_factory=dict)
    all: _Robot | None = None

    def type_of(self, robot: _Robot) -> _Robot:
        """Return the entry of a robot's type, empty if there is none."""
        return self.robot_types.get(str(robot.type)) or _Robot()

    def type_connection(self, robot: _Robot) -> object:
        """Return the connection of a robot's type, the only one that Crazyswarm2's servers read."""
        return self.type_of(robot).connection or CRAZYFLIE

    def is_flown(self, robot: _Robot) -> bool:
        """Return whether a robot is enabled and, by its own connection before its type's, a Crazyflie."""
        return robot.enabled and (robot.connection or self.type_connection(robot)) == CRAZYFLIE


def crazyflies_from_file(path: str) -> tuple[Crazyflie, ...]:
    """Return the enabled vehicles of a `crazyflies.yaml`, in its order.

    Raises:
        ValueError: the file cannot be read, or as crazyflies_from_document.
    """
    return crazyflies_from_document(load_yaml(Path(path)))


def crazyflies_from_document(document: object) -> tuple[Crazyflie, ...]:
    """Return the enabled vehicles of a parsed `crazyflies.yaml`, in its order.

    Raises:
        ValueError: naming the vehicle, the key and what is allowed; none is enabled; a URI is used twice.
    """
    fleet = from_plain(_Fleet, document, "crazyflies.yaml", extra=True)
    enabled = tuple(
        Crazyflie(name, robot.uri, robot.initial_position, _params_of(fleet, name, robot))
        for name, robot in fleet.robots.items()
        if fleet.is_flown(robot)
    )
    if not enabled:
        raise ValueError("robots: none is enabled with `connection: crazyflie`; set `enabled: true`")
    _check(enabled)
    return enabled


def check_connections(document: object) -> None:
    """Check that Crazyswarm2's servers fly the robots that crazyflies_from_document returns.

    Raises:
        ValueError: the `connection` of an enabled robot, which they do not read, differs from its type's.
    """
    fleet = from_plain(_Fleet, document, "crazyflies.yaml", extra=True)
    for name, robot in fleet.robots.items():
        by_type = fleet.type_connection(robot)
        if robot.enabled and robot.connection not in (None, by_type):
            raise ValueError(
                f"robots.{name}.connection = {robot.connection!r}: Crazyswarm2 reads connection only from "
                f"robot_types, {by_type!r} here: give {name} another type, or set `enabled: false`"
            )


def _check(vehicles: Sequence[Crazyflie]) -> None:
    """Raise ValueError for a name that is none of a topic, a URI that is none, and for either used twice."""
    check_unique([one.name for one in vehicles])
    reached = [canonical_uri(one.uri) for one in vehicles]
    for one, own in zip(vehicles, reached, strict=True):
        check_vehicle_name(one.name)
        if not one.uri.startswith(SCHEMES):
            raise ValueError(f"{one.name}: uri = {one.uri!r}; must be {URI}")
        sharing = [other.name for other, uri in zip(vehicles, reached, strict=True) if uri == own]
        if len(sharing) > 1:
            raise ValueError(f"{' and '.join(sharing)} have the same uri {one.uri}: each needs its own")


def params_set(document: object, name: str, *, by_type: bool) -> dict[str, float]:
    """Return the firmware parameters that a server sets on a vehicle, `group.name` by `group.name`.

    Values of the robot override those of its type (if `by_type`: the cflib server sets none of a type), and
    these override those of `all`.

    Raises:
        ValueError: a value is not a number, or as crazyflies_from_document.
    """
    fleet = from_plain(_Fleet, document, "crazyflies.yaml", extra=True)
    return _params_of(fleet, name, fleet.robots.get(name, _Robot()), by_type=by_type)


def _params_of(fleet: _Fleet, name: str, robot: _Robot, *, by_type: bool = True) -> dict[str, float]:
    levels = {
        "all": fleet.all or _Robot(),
        f"robot_types.{robot.type}": fleet.type_of(robot) if by_type else _Robot(),
        f"robots.{name}": robot,
    }
    return {
        f"{group}.{parameter}": _as_float(value, f"{place}.firmware_params.{group}.{parameter}")
        for place, level in levels.items()
        for group, values in (level.firmware_params or {}).items()
        for parameter, value in (values or {}).items()
    }


def _as_float(value: object, place: str) -> float:
    """Return the YAML number at a place; infinite, which no parameter can be, if it exceeds every float."""
    if not isinstance(value, int | float):
        raise ValueError(f"crazyflies.yaml: {place} = {value!r}; must be a number")  # noqa: TRY004  the file is wrong
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf
