"""Plans as JSON files, exact to the last bit.

A file holds names, durations and coefficients (shortest decimals that round-trip), and what the plan was
checked against and costs. It is data only: reading one runs no code.

A checksum over all entries detects a plan that was edited after it was certified. It keeps nobody from
writing another: q2q_planner.offline.certificate.certified_file proves a plan again.
"""

import json
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from pathlib import Path

import numpy as np

from q2q_model.documents.checksummed_json import checksum
from q2q_model.documents.read_text import read_text
from q2q_model.documents.written_file import write_text
from q2q_model.signals.values import Array
from q2q_model.signals.vehicle_name import check_vehicle_name
from q2q_model.trajectory.polynomials import AXES, SwarmPlan, Trajectory

FORMAT = "q2q_plan"
VERSION = 1

LARGEST = 1e30
"""Largest coefficient: above 1e4 m over the 7th power of the shortest piece, 1 ms."""

MOST_COEFFICIENTS = 32
"""Most coefficients of a polynomial, whose roots a proof finds; minimum snap has 8."""

REMEDY = "write one with `ros2 run q2q_planner plan`"


@dataclass(frozen=True, slots=True)
class PlanFacts:
    """Properties of a plan in addition to its trajectories; NaN where unknown."""

    zone: str = "none"
    """Description of the zone that every pair avoids."""
    snap_cost: float = nan
    """Cost (18) of the plan."""
    snap_infimum: float = nan
    """Cost (18) without avoidance [same unit]."""
    clearance: float = nan
    """Minimum signed distance of any pair to the zone over all t [m]."""


def encode(plan: SwarmPlan, facts: PlanFacts | None = None) -> str:
    """Return the plan as JSON text."""
    known = facts or PlanFacts()
    vehicles = [
        {"name": name, "durations": curve.durations.tolist(), "coefficients": curve.coefficients.tolist()}
        for name, curve in zip(plan.names, plan.trajectories, strict=True)
    ]
    document: dict[str, object] = {
        "format": FORMAT,
        "version": VERSION,
        "axes": "x y z [m], yaw [rad]; ascending powers of the time [s] since the piece's start",
        "certified": plan.certified,
        "zone": known.zone,
        "zone_profile_m": [list(corner) for corner in plan.zone_profile],
        "snap_cost": _or_null(known.snap_cost),
        "snap_infimum": _or_null(known.snap_infimum),
        "clearance_m": _or_null(known.clearance),
        "vehicles": vehicles,
    }
    return json.dumps(document | {"checksum": checksum(document)}, allow_nan=False)


def decode(text: str, source: str = "plan") -> tuple[SwarmPlan, PlanFacts]:
    """Return the plan and its facts from JSON text.

    A plan that states to be certified and has no checksum, as older files, is taken as not certified.

    Raises:
        ValueError: the text is no plan; the message names `source`, what was found and what is expected.
    """
    try:
        document = _mapping(json.loads(text), "the file")
        _check_format(document)
        rows = _list(document.get("vehicles"), "vehicles")
        named = [_vehicle(row, index) for index, row in enumerate(rows)]
        names, curves = (tuple(name for name, _ in named), tuple(curve for _, curve in named))
        plan = SwarmPlan(names, curves, _certified(document, source), _profile(document))
        facts = _facts(document)
    except (ValueError, OverflowError, RecursionError) as error:  # a JSONDecodeError is a ValueError
        raise ValueError(f"{source} is not a plan: {error}; {REMEDY}") from error
    return plan, facts


def _certified(document: Mapping[str, object], source: str) -> bool:
    """Return whether the plan was certified as it is; raise ValueError if it was edited since."""
    stated = document.get("certified")
    if not isinstance(stated, bool):
        raise ValueError(f"certified = {stated!r}: expected true or false")  # noqa: TRY004
    if not stated:
        return False
    if "checksum" not in document:
        warnings.warn(f"{source} has no checksum: treated as not certified", stacklevel=4)
        return False
    if document["checksum"] != checksum({key: one for key, one in document.items() if key != "checksum"}):
        raise ValueError(
            "the checksum does not match: it was edited after it was certified (set certified = false to "
            "read it without a proof)"
        )
    return True


def _profile(document: Mapping[str, object]) -> tuple[tuple[float, float], ...]:
    rows = _array(document.get("zone_profile_m", []), "zone_profile_m")
    pairs = rows.size == 0 or (rows.ndim == 2 and rows.shape[1] == 2)
    if not pairs or not ((rows >= 0.0) & (rows <= LARGEST)).all():
        raise ValueError("zone_profile_m: expected pairs of a radius and a height, each at least 0 m")
    return tuple((float(radius), float(height)) for radius, height in rows.reshape(-1, 2))


def _facts(document: Mapping[str, object]) -> PlanFacts:
    return PlanFacts(
        zone=str(document.get("zone", "none")),
        snap_cost=_fact(document, "snap_cost"),
        snap_infimum=_fact(document, "snap_infimum"),
        clearance=_fact(document, "clearance_m"),
    )


def save(path: Path, plan: SwarmPlan, facts: PlanFacts | None = None) -> None:
    """Write the plan to a file."""
    write_text(encode(plan, facts) + "\n", path)


def load(path: Path) -> SwarmPlan:
    """Return the plan in a file; raise as `load_with_facts`."""
    return load_with_facts(path)[0]


def load_with_facts(path: Path) -> tuple[SwarmPlan, PlanFacts]:
    """Return the plan in a file and its facts.

    Raises:
        ValueError: the file is absent, unreadable or no plan.
    """
    try:
        text = read_text(path)
    except ValueError as error:
        raise ValueError(f"plan {path} {error}") from error
    return decode(text, str(path))


def _check_format(document: Mapping[str, object]) -> None:
    given = document.get("format"), document.get("version")
    if given != (FORMAT, VERSION):
        raise ValueError(f"format and version are {given}, expected {(FORMAT, VERSION)}")


def _vehicle(row: object, index: int) -> tuple[str, Trajectory]:
    entry = _mapping(row, f"vehicle {index}")
    name = entry.get("name")
    if not isinstance(name, str):
        raise ValueError(f"vehicle {index}: name = {name!r}, expected text")  # noqa: TRY004
    check_vehicle_name(name)
    durations = _array(entry.get("durations"), f"{name}: durations")
    coefficients = _array(entry.get("coefficients"), f"{name}: coefficients")
    if coefficients.ndim != 3 or not 1 <= coefficients.shape[2] <= MOST_COEFFICIENTS:
        shape = f"{name}: coefficients have shape {coefficients.shape}"
        raise ValueError(f"{shape}, expected (pieces, {AXES}, 1 to {MOST_COEFFICIENTS})")
    if not (np.abs(coefficients) <= LARGEST).all() or not (durations <= LARGEST).all():
        raise ValueError(f"{name}: durations and coefficients must be numbers of at most {LARGEST:g}")
    try:
        return name, Trajectory(durations, coefficients)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error


def _array(value: object, where: str) -> Array:
    try:
        given = np.array(_list(value, where), dtype=object)
    except ValueError as error:
        raise ValueError(f"{where}: expected nested lists of numbers ({error})") from error
    others = {type(one).__name__ for one in given.flat} - {"int", "float"}  # a string or true would convert
    if others:
        raise ValueError(f"{where}: expected nested lists of numbers (got {', '.join(sorted(others))})")
    return given.astype(np.float64)


def _fact(document: Mapping[str, object], key: str) -> float:
    value = document.get(key)
    return float(value) if isinstance(value, int | float) else nan


def _or_null(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _list(value: object, where: str) -> list[object]:
    if not isinstance(value, list):
        raise ValueError(f"{where}: got {type(value).__name__}, expected a list")  # noqa: TRY004
    return value


def _mapping(value: object, where: str) -> Mapping[str, object]:
    if not isinstance(value, dict):
        raise ValueError(f"{where}: got {type(value).__name__}, expected an object")  # noqa: TRY004
    return value
