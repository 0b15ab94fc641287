"""Last measured poses of a plan's vehicles, and the reference that follows them."""

from math import isfinite

import numpy as np

from q2q_model.geometry.rotations import yaw_from_quat
from q2q_model.signals.values import Array, MocapFrame, Names, SetpointStatus, SwarmSetpoint, index_of


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

    def reference(self, t: float) -> SwarmSetpoint:
        """Return the reference at rest at the measured poses, of stamp t [s].

        Raises:
            ValueError: a vehicle has not been measured yet.
        """
        seen = self.poses()
        missing = [
            name for name, one in zip(self._names, seen, strict=True) if not np.isfinite(one[:3]).all()
        ]
        if missing:
            raise ValueError(f"{', '.join(missing)} has not been measured yet: no reference before that")
        n = len(self._names)
        return SwarmSetpoint(
            t=t,
            names=self._names,
            pos=seen[:, :3].copy(),
            vel=np.zeros((n, 3)),
            acc=np.zeros((n, 3)),
            yaw=seen[:, 3].copy(),
            yaw_rate=np.zeros(n),
            status=np.full(n, int(SetpointStatus.NOMINAL), dtype=np.uint8),
        )
