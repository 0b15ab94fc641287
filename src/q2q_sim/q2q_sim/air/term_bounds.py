"""Bounds of the numbers of an air's terms: NaN and correlation times of 0 would reach the vehicles."""

from dataclasses import fields
from typing import Any

import numpy as np

ABOVE_ZERO = (
    "width_m", "time_s", "radius_m", "rotor_radius_m", "gust_time_s", "headroom", "attitude_frequency",
    "attitude_damping",
)  # fmt: skip
"""Fields of terms whose numbers are above 0."""
NOT_NEGATIVE = (
    "share", "std", "floor_mps2", "gain_std", "gust_std_mps2", "offset_std_mps2", "thrust_lag_s",
    "headroom_std", "motor_std", "attitude_lead_ratio", "per_s",
)  # fmt: skip
"""Fields of terms whose numbers are 0 or more; all others are any finite numbers."""


def check_term(name: str, term: Any) -> None:  # noqa: ANN401  any dataclass
    """Raise ValueError for a number of a term that is not allowed, with its field and what is."""
    for entry in fields(term):
        given = getattr(term, entry.name)
        numbers = np.atleast_1d(np.asarray([] if given is None else given, dtype=np.float64))
        low, allowed = _bound(entry.name)
        for wrong in numbers[~(np.isfinite(numbers) & (numbers >= low))][:1]:
            raise ValueError(f"{name}.{entry.name} has {wrong}: {allowed}")


def _bound(field: str) -> tuple[float, str]:
    """Return the smallest number allowed in a field, and what is allowed as text."""
    if field in ABOVE_ZERO:
        return np.nextafter(0.0, 1.0), "a finite number above 0 is allowed"
    if field in NOT_NEGATIVE:
        return 0.0, "a finite number, 0 or more, is allowed"
    return -np.inf, "finite numbers are allowed"
