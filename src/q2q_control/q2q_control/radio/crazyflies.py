"""Vehicles of Crazyswarm2's `crazyflies.yaml`.

    robots:
      cf1: {enabled: true, uri: radio://0/80/2M/E7E7E7E701, initial_position: [0, 0, 0], type: cf21}

Of other keys, only `firmware_params` is read, whose values the server sets. A robot with `connection: none`,
its own or its type's, is skipped: it is tracked by motion capture but not flown.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import yaml

from q2q_model.signals.values import Names


@dataclass(frozen=True, slots=True)
class Crazyflie:
    """Enabled vehicle."""

    name: str
    uri: str
    start: tuple[float, float, float]
    """Initial position [m], world."""


def crazyflies_at(names: Names, uris: Sequence[str]) -> tuple[Crazyflie, ...]:
    """Return vehicles given by name and URI instead of a file.

    Raises:
        ValueError: there are none.
    """
    if not names:
        raise ValueError("no vehicles: set crazyflies:=FILE, or vehicles and uris")
    return tuple(Crazyflie(name, uri, (0.0, 0.0, 0.0)) for name, uri in zip(names, uris, strict=True))


def crazyflies_from_file(path: str) -> tuple[Crazyflie, ...]:
    """Return the enabled vehicles of a `crazyflies.yaml`, in its order.

    Raises:
        ValueError: as crazyflies_from_document.
        OSError: the file cannot be read.
    """
    return crazyflies_from_document(document_of(path))


def document_of(path: str) -> object:
    """Return the parsed content of a YAML file."""
    return yaml.safe_load(Path(path).read_text(encoding="utf-8"))


def crazyflies_from_document(document: object) -> tuple[Crazyflie, ...]:
    """Return the enabled vehicles of a parsed `crazyflies.yaml`, in its order.

    Raises:
        ValueError: naming the vehicle, the key and what is allowed; none is enabled; a URI is used twice.
    """
    whole = _mapping(document, "crazyflies.yaml")
    types = _mapping(whole.get("robot_types", {}), "robot_types")
    robots = {
        str(name): _mapping(entry, str(name))
        for name, entry in _mapping(whole.get("robots"), "robots").items()
    }
    read = [_crazyflie(name, entry) for name, entry in robots.items() if _is_flown(entry, types)]
    enabled = tuple(one for one in read if one is not None)
    if not enabled:
        raise ValueError("robots: none is enabled; set `enabled: true`")
    for one in enabled:
        twins = [other.name for other in enabled if other.uri == one.uri]
        if len(twins) > 1:
            raise ValueError(f"{' and '.join(twins)} have the same uri {one.uri}: each needs its own")
    return enabled


def params_set(document: object, name: str, *, by_type: bool) -> dict[str, float]:
    """Return the firmware parameters that a server sets on a vehicle, `group.name` by `group.name`.

    Values of the robot override those of its type (if `by_type`: the cflib server sets none of a type), and
    these override those of `all`.
    """
    whole = _mapping(document, "crazyflies.yaml")
    robot = _mapping(_mapping(whole.get("robots"), "robots").get(name), name)
    kind = _mapping(whole.get("robot_types", {}), "robot_types").get(robot.get("type"), {})
    levels = (whole.get("all") or {}, kind if by_type else {}, robot)
    groups = [_mapping(_mapping(level, name).get("firmware_params") or {}, name) for level in levels]
    return {
        f"{group}.{parameter}": float(value)
        for some in groups
        for group, values in some.items()
        for parameter, value in _mapping(values or {}, str(group)).items()
        if isinstance(value, int | float)
    }


def _is_flown(robot: Mapping[object, object], types: Mapping[object, object]) -> bool:
    """Return whether a robot is connected to; `connection` is its own, or its type's."""
    kind = types.get(robot.get("type"), {})
    of_type = kind.get("connection") if isinstance(kind, Mapping) else None
    return robot.get("connection", of_type) != "none"


def _crazyflie(name: str, entry: Mapping[object, object]) -> Crazyflie | None:
    enabled = entry.get("enabled", False)
    if enabled not in {True, False}:
        raise ValueError(f"{name}: enabled = {enabled!r}: true or false is expected")
    if not enabled:
        return None
    uri = entry.get("uri")
    if not isinstance(uri, str) or "://" not in uri:
        raise ValueError(f"{name}: uri = {uri!r}: something like radio://0/80/2M/E7E7E7E701 is expected")
    return Crazyflie(name, uri, _position(name, entry.get("initial_position", [0.0, 0.0, 0.0])))


def _position(name: str, value: object) -> tuple[float, float, float]:
    if isinstance(value, list) and len(value) == 3 and all(_is_number(one) for one in value):
        x, y, z = (float(one) for one in value)
        return x, y, z
    raise ValueError(f"{name}: initial_position = {value!r}: three numbers [m] are expected")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)


def _mapping(value: object, where: str) -> Mapping[object, object]:
    if isinstance(value, Mapping):
        return value
    raise ValueError(f"{where}: got {value!r}, expected names with values")
