"""Bounds of the numbers of an air's terms: NaN and correlation times of 0 would reach the vehicles.

Accelerations are bounded as those of interaction models are (q2q_model.model_files.model_bounds): a force in
another unit would throw vehicles out of the room. What learn_air learns is bounded more tightly, by the
momentum of a source (q2q_sim.air.learning.jet.plausibility).
"""

from dataclasses import fields
from typing import Any

import numpy as np

from q2q_model.model_files.model_bounds import LARGEST

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
ACCELERATIONS = ("push_mps2", "floor_mps2", "gust_std_mps2", "offset_std_mps2")
"""Fields of terms whose numbers are at most LARGEST in magnitude [m/s^2]."""


def check_term(name: str, term: Any) -> None:  # noqa: ANN401  any dataclass
    """Raise ValueError for a number of a term that is not allowed, with its field and what is."""
    for entry in fields(term):
        given = getattr(term, entry.name)
        numbers = np.atleast_1d(np.asarray([] if given is None else given, dtype=np.float64))
        low, allowed = _bound(entry.name)
        most = LARGEST if entry.name in ACCELERATIONS else np.inf
        within = np.isfinite(numbers) & (numbers >= low) & (np.abs(numbers) <= most)
        for wrong in numbers[~within][:1]:
            up_to = "" if np.isinf(most) else f", at most {most:.3g} in magnitude"
            raise ValueError(f"{name}.{entry.name} has {wrong}; must be {allowed}{up_to}")


def _bound(field: str) -> tuple[float, str]:
    """Return the smallest number allowed in a field, and what is allowed as text."""
    if field in ABOVE_ZERO:
        return np.nextafter(0.0, 1.0), "finite and above 0"
    if field in NOT_NEGATIVE:
        return 0.0, "finite and at least 0"
    return -np.inf, "finite"
