"""Counts of what the mocap filter did with frames."""

from dataclasses import fields

import numpy as np

from q2q_model.estimation.filter_report import FilterReport
from q2q_model.estimation.frame_rows import FrameRows
from q2q_model.estimation.position.track_update import TrackUpdate
from q2q_model.signals.values import Mask


class FrameCounts:
    """Counts since the filter's start."""

    def __init__(self) -> None:
        """Start at zero."""
        self._counts = {entry.name: 0 for entry in fields(FilterReport)}

    @property
    def report(self) -> FilterReport:
        """Return the counts so far."""
        return FilterReport(**self._counts)

    def add(self, what: str, count: int = 1) -> None:
        """Add to one of the counts of FilterReport."""
        self._counts[what] += count

    def add_frame(self, rows: FrameRows, tracks: int) -> None:
        """Count a frame, as if each of the tracks had a sample."""
        counts = self._counts
        counts["frames"] += 1
        counts["repeated_names"] += rows.repeated
        counts["unknown_names"] += rows.unknown
        counts["samples"] += tracks

    def add_tick(self, rows: FrameRows, present: Mask, tracked: TrackUpdate) -> Mask:
        """Count what was done with a tick's samples (n,); return those that no track accepted, (n,)."""
        self.add_frame(rows, len(present))
        if tracked.nominal:
            return np.zeros(len(present), dtype=np.bool_)
        counts, used = self._counts, np.zeros(len(present), dtype=np.bool_)
        used[tracked.source[tracked.accepted]] = True
        counts["samples"] += int(present.sum()) - len(present)
        counts["swapped"] += int(tracked.borrowed.sum())
        counts["refused"] += int((present & ~used).sum())
        counts["restarted"] += int(tracked.restarted.sum())
        counts["not_finite"] += int((rows.tracks >= 0).sum() - present.sum())
        return present & ~used
