"""Last measured poses of a plan's vehicles, and the reference at rest that follows them.

A position that is measured farther from the reference than SEEN_AT_REST allows is an outlier, unless the next
one that is measured of this vehicle confirms it: then the vehicle was carried there.
"""

from math import isfinite

import numpy as np

from q2q_model.counted import listed
from q2q_model.geometry.rotations import yaw_from_quat
from q2q_model.signals.values import Array, Mask, MocapFrame, Names, SetpointStatus, SwarmSetpoint, index_of

SEEN_AT_REST = 2.0
"""Speed between two measured positions above which one is an outlier or the vehicle moves [m/s]."""
LONGEST_TICK = 0.1
"""Longest time between two measured positions that counts [s]: what is measured far away after a gap is an
outlier until it is confirmed."""


class MeasuredPoses:
    """Positions and yaw of vehicles, as last measured."""

    def __init__(self, names: Names) -> None:
        """Start without measurements of the named vehicles."""
        self._names = names
        self._seen = np.full((len(names), 4), np.nan)
        self._whole: MocapFrame | None = None  # last frame, if it shows all vehicles

    def update(self, frame: MocapFrame) -> Mask:
        """Take the poses measured in a frame; return whose position it has, (n,).

        Those of a whole frame are converted when asked for.
        """
        if frame.names == self._names and isfinite(np.vdot(frame.pos, frame.pos)):
            self._whole = frame
            return np.ones(len(self._names), dtype=np.bool_)
        self._seen, self._whole = self.known_poses(), None
        rows = index_of(frame.names, self._names)
        seen = (rows >= 0) & np.isfinite(frame.pos).all(axis=1)
        yaw = yaw_from_quat(frame.quat[seen])
        self._seen[rows[seen], :3] = frame.pos[seen]
        self._seen[rows[seen], 3] = np.where(np.isfinite(yaw), yaw, 0.0)
        measured = np.zeros(len(self._names), dtype=np.bool_)
        measured[rows[seen]] = True
        return measured

    def known_poses(self) -> Array:
        """Return the last measured positions [m] and yaw [rad], (n, 4); NaN of one never measured."""
        if self._whole is None:
            return self._seen.copy()
        yaw = yaw_from_quat(self._whole.quat)
        return np.column_stack([self._whole.pos, np.where(np.isfinite(yaw), yaw, 0.0)])

    def complete_poses(self) -> Array:
        """Return the last measured positions [m] and yaw [rad], (n, 4).

        Raises:
            ValueError: a vehicle has not been measured yet.
        """
        seen = self.known_poses()
        missing = [
            name for name, one in zip(self._names, seen, strict=True) if not np.isfinite(one[:3]).all()
        ]
        if missing:
            raise ValueError(f"{listed(missing)} not measured yet: no reference until then")
        return seen


class RestingReference:
    """Reference at rest where vehicles are measured; it does not follow single outliers."""

    def __init__(self, names: Names) -> None:
        """Start without poses of the named vehicles."""
        self._names = names
        self.reset()

    def reset(self) -> None:
        """Rest where vehicles are measured next; until a second measurement confirms it, at each one."""
        n = len(self._names)
        self.speed = 0.0
        """Largest distance of a measured position from the reference, over the tick [m/s]."""
        self._t = np.full(n, np.nan)
        self._seen, self._rest = np.full((2, n, 4), np.nan)
        self._confirmed = np.zeros(n, dtype=np.bool_)

    @property
    def unconfirmed(self) -> Names:
        """Return the vehicles that have not been measured at rest in two frames."""
        return tuple(name for name, known in zip(self._names, self._confirmed, strict=True) if not known)

    def update(self, poses: Array, measured: Mask, t: float, *, is_late: bool) -> SwarmSetpoint:
        """Return the reference of stamp t [s] at last measured poses (n, 4); a late frame does not move it.

        `measured` are the vehicles in the frame, (n,): the others rest where they are.
        """
        taken = np.isnan(self._rest[:, 0])
        if not is_late:
            taken |= self._believed(poses, measured, t - self._t)
            self._seen[measured], self._t[measured] = poses[measured], t
        self._rest = np.where(taken[:, None], poses, self._rest)
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

    def _believed(self, poses: Array, measured: Mask, tick: Array) -> Mask:
        """Return whose measured positions are no outliers, `tick` [s] after the last ones of each, (n,)."""
        believed = measured & ~self._confirmed
        later = measured & (tick > 0.0)  # not a vehicle's first frame, or of a clock that was set back
        if not later.any():
            return believed
        counted = np.minimum(tick[later], LONGEST_TICK)
        off, moved = (_distances(poses, one)[later] / counted for one in (self._rest, self._seen))
        again = moved <= SEEN_AT_REST
        self._confirmed[later] |= again
        self.speed = float(off.max())
        believed[later] |= (off <= SEEN_AT_REST) | again
        return believed


def _distances(first: Array, second: Array) -> Array:
    """Return the distances of the positions in poses (n, 4) [m], (n,)."""
    apart: Array = np.linalg.norm(first[:, :3] - second[:, :3], axis=1)
    return apart
