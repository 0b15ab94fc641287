"""Commands as Crazyswarm2's servers expect them, and motion capture as they publish it.

Both servers subscribe to the same topics, but pass `cmd_vel_legacy` on with different signs of pitch:

| backend | pitch on the wire (legacy, nose up) | so linear.x is | angular.z is |
|---|---|---|---|
| cpp (crazyflie_cpp) | -linear.x | theta, nose down | -r, to the right |
| cflib | linear.x, negated twice | -theta, nose up | -r, to the right |

The firmware negates the yaw rate of RPYT itself, so both expect it to the right. `cmd_full_state` has no such
difference: angular velocities are rad/s, body, in both. A pose without orientation has NaN in all four
components of its quaternion (the servers check different ones).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from q2q_control.radio.link.rpyt_scale import RpytScale, rpyt_rows
from q2q_model.estimation.attitude.attitude_tracks import measured_attitudes
from q2q_model.signals.stamps import time_from_stamp
from q2q_model.signals.values import (
    Array,
    MocapFrame,
    Names,
    SwarmCommand,
    SwarmState,
    TrackStatus,
    given_twice,
)

BACKENDS = ("cpp", "cflib")
DEFAULT_BACKEND = "cpp"
"""Backend that Crazyswarm2 launches unless configured otherwise."""
_PITCH_SIGN = {"cpp": 1.0, "cflib": -1.0}


@dataclass(frozen=True, slots=True)
class NamedPose:
    """Pose from motion capture."""

    name: str
    pos: tuple[float, float, float]
    """[m], world."""
    quat: tuple[float, float, float, float]
    """x y z w, body to world; NaN where unknown."""


def legacy_twists(command: SwarmCommand, scale: RpytScale, backend: str) -> Array:
    """Return linear.x [deg], linear.y [deg], angular.z [deg/s], linear.z [PWM] of every vehicle, (n, 4)."""
    signs = np.array([_PITCH_SIGN[backend], 1.0, -1.0, 1.0])
    return np.asarray(rpyt_rows(command, scale) * signs)


def mocap_frame(stamp_ns: int, poses: Sequence[NamedPose], vehicles: Names) -> MocapFrame:
    """Return the frame of the known vehicles given once; an incomplete orientation becomes NaN."""
    duplicates = duplicate_names(poses, vehicles)
    known = [one for one in poses if one.name in vehicles and one.name not in duplicates]
    quat = np.array([one.quat for one in known]).reshape(len(known), 4)
    whole = np.isfinite(quat).all(axis=1, keepdims=True)
    return MocapFrame(
        t=time_from_stamp(stamp_ns),
        names=tuple(one.name for one in known),
        pos=np.array([one.pos for one in known]).reshape(len(known), 3),
        quat=np.where(whole, quat, np.nan),
    )


def duplicate_names(poses: Sequence[NamedPose], vehicles: Names) -> Names:
    """Return the known vehicles that have more than one pose: either may be another vehicle's."""
    duplicates = given_twice(one.name for one in poses)
    return tuple(name for name in vehicles if name in duplicates)


def poses_of(state: SwarmState) -> list[NamedPose]:
    """Return the filtered poses of the vehicles measured in this frame; orientation NaN for lone markers."""
    rows = np.flatnonzero(state.status == TrackStatus.TRACKED)
    known = np.where(measured_attitudes(state)[:, None], state.quat, np.nan)
    pos, quat = state.pos[rows].tolist(), known[rows].tolist()
    return [
        NamedPose(state.names[row], (x, y, z), (qx, qy, qz, qw))
        for row, (x, y, z), (qx, qy, qz, qw) in zip(rows, pos, quat, strict=True)
    ]
