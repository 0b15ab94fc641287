"""Horizontal motion of vehicles without measurements, integrated from their own commands.

    a' = (g u(phi, theta, psi) - a) / L           u: horizontal part of the body's z axis
    v' = a,  p' = v                               a_0: of the last measured attitude
    V  = v + L a                                  velocity once all commands have taken effect

Wind is not modelled: its drift remains. Columns of a track, (n, 7): X, Y, VX, VY, AX, AY, YAW.

| symbol | name | meaning [unit] |
|---|---|---|
| p | X, Y | horizontal position, world [m] |
| v | VX, VY | horizontal velocity, world [m/s] |
| a | AX, AY | horizontal acceleration, world [m/s^2] |
| phi theta psi | roll pitch yaw | commanded roll and pitch, last measured yaw [rad] |
| L | LAG_S | from a command to its tilt [s] |
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.geometry.rotations import rotate, yaw_from_quat
from q2q_model.signals.values import Array, SwarmState
from q2q_model.vehicle.constants import GRAVITY

LAG_S = 0.15
"""From a command to its tilt [s]: 26 ms of camera and radio, 2 zeta / w_n = 0.12 s (attitude_law)."""

X, Y, VX, VY, AX, AY, YAW = range(7)
UP = np.array([0.0, 0.0, 1.0])
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
UNKNOWN = np.array([np.nan, np.nan, 0.0, 0.0, 0.0, 0.0, 0.0])
"""Track of a vehicle that was never measured: at rest, position unknown."""


class Reckoned(NamedTuple):
    """Horizontal motion of a vehicle without measurements."""

    pos: Array
    """Position now [m], (2,)."""
    rest: Array
    """Position at which it comes to rest by braking [m], (2,)."""


class Sight(NamedTuple):
    """Measured tracks, and the age of each."""

    track: Array
    """(n, 7)."""
    age: Array
    """[s], (n,); infinite where a vehicle is not in the state."""


def measured_tracks(state: SwarmState) -> Array:
    """Return the tracks of a state, (n, 7)."""
    size = np.square(state.quat).sum(axis=1, keepdims=True)
    known = np.isfinite(size) & (size > 0.0)  # any message may come: no attitude is level
    acc = GRAVITY * rotate(np.where(known, state.quat, LEVEL), UP)[:, :2]
    yaw = yaw_from_quat(state.quat)[:, None]
    return np.concatenate((state.pos[:, :2], state.vel[:, :2], acc, yaw), axis=1)


@compiled
def propagate(track: Array, tilts: Array, elapsed: float) -> None:
    """Propagate tracks (n, 7) in place by `elapsed` [s] under commanded roll and pitch (n, 2) [rad]."""
    decay = math.exp(-elapsed / LAG_S)
    for i in range(track.shape[0]):
        one, roll, pitch = track[i], tilts[i, 0], tilts[i, 1]
        ahead, aside = GRAVITY * math.sin(pitch) * math.cos(roll), -GRAVITY * math.sin(roll)
        cos, sin = math.cos(one[YAW]), math.sin(one[YAW])
        for k in range(2):
            asked = cos * ahead - sin * aside if k == 0 else sin * ahead + cos * aside
            lacking = one[AX + k] - asked
            before = one[VX + k]
            one[VX + k] += asked * elapsed + lacking * LAG_S * (1.0 - decay)
            one[AX + k] = asked + lacking * decay
            one[X + k] += 0.5 * elapsed * (before + one[VX + k])
