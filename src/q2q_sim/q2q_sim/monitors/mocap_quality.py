"""Quality of motion capture in a flight: rate, gaps, missing vehicles, rejected measurements.

Computed from frames and filtered states, so that it works on any bag, without the true states.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_model.flights.flight import Flight

REJECTED_OFFSET = 0.02
"""Distance from the filtered state beyond which a measurement counts as rejected [m]: ten times VICON's
dynamic error of 2 mm (Merriaux et al., A study of Vicon system positioning performance, Sensors 2017)."""


@dataclass(frozen=True, slots=True)
class MocapQuality:
    """Quality of one vehicle's motion capture."""

    rate_hz: float
    """Median rate of the frames with the vehicle."""
    seen_share: float
    """Fraction of all frames with the vehicle."""
    longest_gap_s: float
    """Longest time between two frames with the vehicle."""
    rejected: float
    """Number of measurements that the filter did not follow; NaN without its states."""


def mocap_quality(flight: Flight) -> dict[str, MocapQuality]:
    """Return the motion-capture quality of each vehicle of a flight."""
    rejected = rejected_samples(flight)
    return {name: _of(flight, rejected, row) for row, name in enumerate(flight.names)}


def rejected_samples(flight: Flight) -> NDArray[np.bool_]:
    """Return the measurements that the filter did not follow, (T, n)."""
    offset = np.linalg.norm(flight.mocap_pos - flight.pos, axis=-1)
    return np.asarray(np.isfinite(offset) & (offset > REJECTED_OFFSET))


def _of(flight: Flight, rejected: NDArray[np.bool_], row: int) -> MocapQuality:
    seen = np.isfinite(flight.mocap_pos[:, row, 0])
    stamps = flight.t[seen]
    gaps = np.diff(stamps)
    return MocapQuality(
        rate_hz=float(1.0 / np.median(gaps)) if len(gaps) else 0.0,
        seen_share=float(seen.mean()) if len(seen) else 0.0,
        longest_gap_s=float(gaps.max()) if len(gaps) else float("inf"),
        rejected=int(rejected[:, row].sum()) if np.isfinite(flight.pos[:, row]).any() else np.nan,
    )
