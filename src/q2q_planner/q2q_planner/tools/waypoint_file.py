"""Reader of a YAML file of waypoints; an error is one line with the place in the file."""

from collections.abc import Iterator
from pathlib import Path

import yaml

from q2q_planner.offline.minimum_snap.flight_limits import FlightLimits, timed_document
from q2q_planner.offline.minimum_snap.minimum_snap import Reading
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, swarm_from_document


def read_waypoints(path: Path, limits: FlightLimits, reading: Reading) -> tuple[VehicleWaypoints, ...]:
    """Return the waypoints of a file, timed within `limits` if it has no times.

    Raises:
        ValueError: naming the file, and vehicle, waypoint and bound or the place in the file.
        OSError: the file cannot be read.
    """
    text = path.read_text(encoding="utf-8", errors="replace")
    try:
        return swarm_from_document(timed_document(_document(text), limits, reading))
    except yaml.YAMLError as error:
        raise ValueError(f"{path}: is not valid YAML: {_one_line(error)}") from error
    except RecursionError as error:
        raise ValueError(f"{path}: is nested too deeply") from error
    except ValueError as error:
        raise ValueError(f"{path}: {' '.join(str(error).split())}") from error


def _document(text: str) -> object:
    """Return the parsed text; a duplicate key, which YAML would silently accept, is an error."""
    node = yaml.compose(text, yaml.SafeLoader)
    for key, line in _keys_given_twice(node, set()):
        raise ValueError(f"line {line}: duplicate key {key!r}: each vehicle needs its own name")
    return yaml.safe_load(text)


def _keys_given_twice(node: yaml.Node | None, seen: set[int]) -> Iterator[tuple[str, int]]:
    """Yield each duplicate key of a mapping, and its line."""
    if node is None or id(node) in seen:
        return
    seen.add(id(node))
    if isinstance(node, yaml.SequenceNode):
        for part in node.value:
            yield from _keys_given_twice(part, seen)
    if isinstance(node, yaml.MappingNode):
        known = set()
        for key, value in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in known:
                    yield key.value, key.start_mark.line + 1
                known.add(key.value)
            yield from _keys_given_twice(value, seen)


def _one_line(error: yaml.YAMLError) -> str:
    if isinstance(error, yaml.MarkedYAMLError) and error.problem_mark is not None:
        return f"line {error.problem_mark.line + 1}: {' '.join(str(error.problem).split())}"
    return " ".join(str(error).split())
