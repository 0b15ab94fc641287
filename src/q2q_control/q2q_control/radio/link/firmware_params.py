"""Firmware parameters to set on a vehicle once connected, and checks that it accepts and holds them."""

import struct
from collections import defaultdict
from collections.abc import Container, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from math import isclose, nan

from q2q_model.counted import listed

CONTROLLER = "stabilizer.controller"
PID, MELLINGER, OUT_OF_TREE = 1.0, 2.0, 6.0
"""Its values. Mellinger's controller uses the acceleration of full states, and so does that of the firmware
app (docs/onboard.md), which corrects the setpoint and lets Mellinger's fly it; 2 would switch the app off."""
FLOWN_BY = {"setpoint": MELLINGER, "command": PID}
"""Controller for what is sent. Commands are computed for the attitude loop of the PID."""
APP = "q2q.enabled"
"""Parameter of vehicles with the firmware app."""
POSE_STD = {"locSrv.extPosStdDev": 0.001, "locSrv.extQuatStdDev": 0.05}
"""Standard deviations of the poses sent [m], [rad], as Crazyswarm2 sets them. Recorded flights gave nothing
better that keeps the yaw of a vehicle at its start (docs/estimators.md)."""
MOMENTARY = frozenset({"kalman.resetEstimation", "health.startPropTest", "health.startBatTest"})
"""Parameters that begin something, and that the firmware then sets to 0 (estimator_kalman.c, health.c): read
back, they have either value."""
FLOATS = {"<e", "<f", "<d"}
"""Layouts of floating-point parameters."""
FLOAT32_ROUNDING = 1e-6
"""Relative; a vehicle stores 24 significant bits."""


def firmware_params(
    entries: tuple[str, ...], mode: str, *, poses: bool = False, of_file: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Return the parameters to set on a vehicle.

    Each overrides those before it: POSE_STD where poses are sent, those of the file of vehicles, the
    controller for what is sent, `entries`.

    Raises:
        ValueError: an entry is not `group.name=value`.
    """
    params = {**(POSE_STD if poses else {}), **(of_file or {}), CONTROLLER: FLOWN_BY[mode]}
    for entry in entries:
        name, _, value = entry.partition("=")
        expected = f"firmware_params: {entry!r}; must be group.name=value"
        if not all(name.strip().partition(".")):
            raise ValueError(expected)
        try:
            params[name.strip()] = float(value)
        except ValueError as wrong:
            raise ValueError(expected) from wrong
    return params


def settings_lines(by_vehicle: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Return what is set on which vehicles, one line for all of the same parameters."""
    vehicles: defaultdict[str, list[str]] = defaultdict(list)
    for name, params in by_vehicle.items():
        vehicles[", ".join(f"{key}={_text(value)}" for key, value in sorted(params.items()))].append(name)
    return [f"firmware_params of {listed(names)}: {text}" for text, names in vehicles.items() if text]


def left_out_lines(
    of_files: Mapping[str, Mapping[str, float]], by_vehicle: Mapping[str, Mapping[str, float]]
) -> list[str]:
    """Return whose controller of the file of vehicles is left out because another one is set."""
    vehicles: defaultdict[float, list[str]] = defaultdict(list)
    for name, of_file in of_files.items():
        flown_by = by_vehicle[name][CONTROLLER]
        same = {flown_by, required_with_app({CONTROLLER: flown_by}, {APP})[CONTROLLER]}
        if of_file.get(CONTROLLER, flown_by) not in same:
            vehicles[flown_by].append(f"{_text(of_file[CONTROLLER])} of {name}")
    left_out = f"{CONTROLLER} of crazyflies is ignored"
    why = "by the mode, or by the parameter firmware_params, which overrides both"
    return [f"{left_out} ({listed(some)}): {_text(one)} is set, {why}" for one, some in vehicles.items()]


def _text(value: float) -> str:
    """Return a value with the digits of the largest one of 32 bits."""
    return f"{value:.10g}"


@dataclass(frozen=True, slots=True)
class TableEntry:
    """Parameter in a vehicle's table of contents."""

    layout: str
    """Format of its value on the wire, as in `struct`."""
    writable: bool


def required_with_app(required: Mapping[str, float], known: Container[str]) -> dict[str, float]:
    """Return the parameters that a vehicle must hold which knows these: the app's controller for Mellinger's.

    The app's is the default of its firmware, and is not set. `q2q.enabled=0` flies without the correction.
    """
    by_app = APP in known and required.get(CONTROLLER) == MELLINGER
    return {**required, CONTROLLER: OUT_OF_TREE} if by_app else dict(required)


def unsettable(required: Mapping[str, float], table: Mapping[str, TableEntry]) -> dict[str, str]:
    """Return why parameters cannot be set on a vehicle with this table, by their names."""
    reasons = {name: _unsettable(name, value, table) for name, value in required.items()}
    return {name: reason for name, reason in reasons.items() if reason}


def _unsettable(name: str, value: float, table: Mapping[str, TableEntry]) -> str:
    if name not in table:
        near = get_close_matches(name, table)
        hint = f"the nearest are {', '.join(near)}" if near else "no name in its table is similar"
        return f"it has no parameter {name} (firmware_params): {hint}"
    if not table[name].writable:
        return f"its {name} is read-only (firmware_params): leave it out"
    layout = table[name].layout
    try:
        struct.pack(layout, value if layout in FLOATS else int(value))
    except (struct.error, OverflowError, ValueError):
        bits = 8 * struct.calcsize(layout)
        return f"its {name} cannot be {_text(value)} (firmware_params): it has {bits} bits"
    return ""


def first_difference(required: Mapping[str, float], held: Mapping[str, float]) -> str:
    """Return the first parameter whose value differs from the required one, with both; empty if none does.

    A momentary one may be 0 again.
    """
    for name, value in required.items():
        found = held.get(name, nan)
        done = name in MOMENTARY and found == 0.0
        if not (done or isclose(found, value, rel_tol=FLOAT32_ROUNDING)):
            return f"its {name} is {found:g}, expected {value:g} (firmware_params)"
    return ""
