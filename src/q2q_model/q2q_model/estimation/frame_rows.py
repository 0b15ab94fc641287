"""Rows of a motion-capture frame, matched by name to the tracks.

Of rows with the same name the first counts; names that are not tracked are ignored.
"""

from dataclasses import dataclass, field

import numpy as np

from q2q_model.estimation.nominal_frame import POSE_WIDTH
from q2q_model.signals.values import Array, MocapFrame, Names, Rows, index_of
from q2q_model.signals.vehicle_name import is_printable_name


@dataclass(frozen=True, slots=True)
class FrameRows:
    """Track of each row of the frames with the same names."""

    names: Names | None = None
    """Names in the frames; None before the first one."""
    tracks: Rows = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    """Track of each row; -1 for rows to ignore."""
    repeated: int = 0
    """Rows with a name that stands in an earlier row, too."""
    unknown: int = 0
    """Names that are not tracked, but could be."""


def new_names(names: Names, tracked: Names) -> Names:
    """Return the names of a frame that are not tracked yet and can be printed, each once."""
    known = set(tracked)
    return tuple(name for name in dict.fromkeys(names) if name not in known and is_printable_name(name))


def match_rows(names: Names, tracked: Names) -> FrameRows:
    """Return the tracks of the rows of a frame with these names."""
    tracks, repeated = index_of(names, tracked), len(names) - len(set(names))
    if repeated:
        tracks[_repeats(names)] = -1
    return FrameRows(names, tracks, repeated, len(new_names(names, tracked)))


def _repeats(names: Names) -> list[int]:
    """Return the rows whose names stand in an earlier row, too."""
    first: dict[str, int] = {}
    return [row for row, name in enumerate(names) if first.setdefault(name, row) != row]


def poses_by_track(frame: MocapFrame, rows: FrameRows, tracked: Names) -> Array:
    """Return the frame's poses in the order of the tracks, (n, 7); NaN where absent."""
    poses = np.concatenate((frame.pos, frame.quat), axis=1)
    if frame.names == tracked:
        return poses
    ours, found = rows.tracks >= 0, np.full((len(tracked), POSE_WIDTH), np.nan)
    found[rows.tracks[ours]] = poses[ours]
    return found


def check_shapes(frame: MocapFrame) -> None:
    """Raise ValueError for a frame whose arrays do not match its names."""
    count = len(frame.names)
    if frame.pos.shape != (count, 3) or frame.quat.shape != (count, 4):
        raise ValueError(
            f"frame at t = {frame.t} has {count} names, pos {frame.pos.shape}, quat {frame.quat.shape}; "
            f"must be ({count}, 3) and ({count}, 4)"
        )
