"""Choose the parameters that vehicles are given once connected, and check that they take and hold them."""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from math import isclose, nan

MELLINGER = 2.0
"""stabilizer.controller of the firmware that takes the acceleration of full states."""
FLOATS = {"<e", "<f", "<d"}
"""Layouts of numbers that need not be whole."""
FLOAT32_ROUNDING = 1e-6
"""Relative; a vehicle keeps 24 bits of a number."""


def firmware_params(asked: tuple[str, ...], mode: str) -> dict[str, float]:
    """Return the parameters to set on a vehicle: Mellinger's controller for full states, then what is asked.

    Raises:
        ValueError: an entry is not `group.name=value`.
    """
    params = {"stabilizer.controller": MELLINGER} if mode == "setpoint" else {}
    for entry in asked:
        name, _, value = entry.partition("=")
        expected = f"firmware_params: {entry!r}: group.name=value is expected"
        if not all(name.strip().partition(".")):
            raise ValueError(expected)
        try:
            params[name.strip()] = float(value)
        except ValueError as wrong:
            raise ValueError(expected) from wrong
    return params


@dataclass(frozen=True, slots=True)
class TableEntry:
    """Parameter in a vehicle's table."""

    layout: str
    """Of its value on the wire, as `struct` writes it."""
    writable: bool


def unsettable(wanted: Mapping[str, float], table: Mapping[str, TableEntry]) -> dict[str, str]:
    """Return why a vehicle with this table cannot be given some of the parameters, by their names."""
    reasons = {name: _unsettable(name, value, table) for name, value in wanted.items()}
    return {name: reason for name, reason in reasons.items() if reason}


def _unsettable(name: str, value: float, table: Mapping[str, TableEntry]) -> str:
    if name not in table:
        near = get_close_matches(name, table)
        hint = f"the nearest are {', '.join(near)}" if near else "no name of its table is near"
        return f"it has no parameter {name} (firmware_params): {hint}"
    if not table[name].writable:
        return f"its {name} can only be read (firmware_params): leave it out"
    layout = table[name].layout
    try:
        struct.pack(layout, value if layout in FLOATS else int(value))
    except (struct.error, OverflowError, ValueError):
        return f"its {name} takes no {value:g} (firmware_params): it has {8 * struct.calcsize(layout)} bits"
    return ""


def difference(wanted: Mapping[str, float], held: Mapping[str, float]) -> str:
    """Return the first parameter that a vehicle does not hold as wanted, with both values; empty if none."""
    for name, value in wanted.items():
        found = held.get(name, nan)
        if not isclose(found, value, rel_tol=FLOAT32_ROUNDING):
            return f"its {name} is {found:g}: {value:g} is wanted (firmware_params)"
    return ""
