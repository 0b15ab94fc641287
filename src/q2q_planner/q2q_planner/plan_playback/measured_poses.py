"""Last measured poses of a plan's vehicles, and the reference at rest that follows them.

A position that is measured farther from the reference than SEEN_AT_REST allows is an outlier, unless the next
one confirms it: then the vehicle was carried there.
"""

from math import isfinite

import numpy as np

from q2q_model.counted import listed
from q2q_model.geometry.rotations import yaw_from_quat
from q2q_model.signals.values import Array, MocapFrame, Names, SetpointStatus, SwarmSetpoint, index_of

SEEN_AT_REST = 2.0
"""Speed between two measured positions above which one is an outlier or the vehicle moves [m/s]."""


class MeasuredPoses:
    """Positions and yaw of vehicles, as last measured."""

    def __init__(self, names: Names) -> None:
        """Start without measurements of the named vehicles."""
        self._names = names
        self._seen = np.full((len(names), 4), np.nan)
        self._whole: MocapFrame | None = None  # last frame, if it shows all vehicles

    def update(self, frame: MocapFrame) -> None:
        """Take the poses measured in a frame; those of a whole one are converted when asked for."""
        if frame.names == self._names and isfinite(np.vdot(frame.pos, frame.pos)):
            self._whole = frame
            return
        self._seen, self._whole = self.poses(), None
        rows = index_of(frame.names, self._names)
        seen = (rows >= 0) & np.isfinite(frame.pos).all(axis=1)
        yaw = yaw_from_quat(frame.quat[seen])
        self._seen[rows[seen], :3] = frame.pos[seen]
        self._seen[rows[seen], 3] = np.where(np.isfinite(yaw), yaw, 0.0)

    def poses(self) -> Array:
        """Return the last measured positions [m] and yaw [rad], (n, 4); NaN of one never measured."""
        if self._whole is None:
            return self._seen
        yaw = yaw_from_quat(self._whole.quat)
        return np.column_stack([self._whole.pos, np.where(np.isfinite(yaw), yaw, 0.0)])

    def all_poses(self) -> Array:
        """Return the last measured positions [m] and yaw [rad], (n, 4).

        Raises:
            ValueError: a vehicle has not been measured yet.
        """
        seen = self.poses()
        missing = [
            name for name, one in zip(self._names, seen, strict=True) if not np.isfinite(one[:3]).all()
        ]
        if missing:
            raise ValueError(f"{listed(missing)} has not been measured yet: no reference before that")
        return seen


class RestingReference:
    """Reference at rest where vehicles are measured; it does not follow single outliers."""

    def __init__(self, names: Names) -> None:
        """Start without poses of the named vehicles."""
        self._names = names
        self.reset()

    def reset(self) -> None:
        """Rest where vehicles are measured next."""
        self.speed = 0.0
        """Largest speed from the reference to the positions measured a tick later [m/s]."""
        self._t = np.nan
        self._seen = self._rest = np.full((len(self._names), 4), np.nan)

    def update(self, seen: Array, t: float, *, is_late: bool) -> SwarmSetpoint:
        """Return the reference of stamp t [s] at measured poses (n, 4); a late frame moves it nowhere."""
        taken = np.isnan(self._rest[:, 0])
        if not is_late:
            if t > self._t:
                off, moved = (_distances(seen, one) / (t - self._t) for one in (self._rest, self._seen))
                self.speed = float(np.nanmax(off, initial=0.0))
                taken |= (off <= SEEN_AT_REST) | (moved <= SEEN_AT_REST)
            self._seen, self._t = seen, t
        self._rest = np.where(taken[:, None], seen, self._rest)
        n = len(self._names)
        return SwarmSetpoint(
            t=t,
            names=self._names,
            pos=self._rest[:, :3].copy(),
            vel=np.zeros((n, 3)),
            acc=np.zeros((n, 3)),
            yaw=self._rest[:, 3].copy(),
            yaw_rate=np.zeros(n),
            status=np.full(n, int(SetpointStatus.NOMINAL), dtype=np.uint8),
        )


def _distances(first: Array, second: Array) -> Array:
    """Return the distances of the positions in poses (n, 4) [m], (n,)."""
    apart: Array = np.linalg.norm(first[:, :3] - second[:, :3], axis=1)
    return apart
