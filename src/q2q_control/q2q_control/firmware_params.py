"""Choose the parameters that vehicles are given once connected, and check what they hold then."""

from collections.abc import Mapping
from math import isclose, nan

MELLINGER = 2.0
"""stabilizer.controller of the firmware that takes the acceleration of full states."""
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
        try:
            params[name.strip()] = float(value)
        except ValueError as wrong:
            raise ValueError(f"firmware_params: {entry!r}: group.name=value is expected") from wrong
    return params


def difference(wanted: Mapping[str, float], held: Mapping[str, float]) -> str:
    """Return the first parameter that a vehicle does not hold as wanted, with both values; empty if none."""
    for name, value in wanted.items():
        found = held.get(name, nan)
        if not isclose(found, value, rel_tol=FLOAT32_ROUNDING):
            return f"its {name} is {found:g}: {value:g} is wanted (firmware_params)"
    return ""
