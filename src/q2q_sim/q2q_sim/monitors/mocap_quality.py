"""Say how well motion capture saw a flight: rate, gaps, what was missing, what the filter did not believe.

Read from the frames and the filtered states of a flight, so that it works on any bag, without a truth.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.flights.flight import Flight

DISBELIEF = 0.02
"""A measurement further than this from the filtered state was not believed [m]: ten times VICON's dynamic
error of 2 mm (Merriaux et al., A study of Vicon system positioning performance, Sensors 2017)."""


@dataclass(frozen=True, slots=True)
class MocapQuality:
    """Quality of one vehicle's motion capture."""

    rate_hz: float
    """Median rate of the frames that hold the vehicle."""
    seen_share: float
    """Share of all frames that hold it."""
    longest_gap_s: float
    """Longest time between two frames that hold it."""
    disbelieved: int
    """Measurements that the filter did not follow."""


def mocap_quality(flight: Flight) -> dict[str, MocapQuality]:
    """Return how well each vehicle of a flight was seen."""
    return {name: _of(flight, row) for row, name in enumerate(flight.names)}


def _of(flight: Flight, row: int) -> MocapQuality:
    seen = np.isfinite(flight.mocap_pos[:, row, 0])
    stamps = flight.t[seen]
    gaps = np.diff(stamps)
    offset = np.linalg.norm(flight.mocap_pos[:, row] - flight.pos[:, row], axis=-1)
    return MocapQuality(
        rate_hz=float(1.0 / np.median(gaps)) if len(gaps) else 0.0,
        seen_share=float(seen.mean()) if len(seen) else 0.0,
        longest_gap_s=float(gaps.max()) if len(gaps) else float("inf"),
        disbelieved=int((offset[np.isfinite(offset)] > DISBELIEF).sum()),
    )
