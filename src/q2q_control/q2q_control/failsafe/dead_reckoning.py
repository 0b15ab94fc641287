"""Motion of vehicles without measurements, integrated from their own commands.

    a'   = (g u(phi, theta, psi) - a) / L         u: horizontal part of the body's z axis
    a_z' = (l - b - a_z) / L_T                    l = g (T cos phi cos theta / T_h - 1)
    b'   = -b / B                                 b_0: mean of l over about B before the last measurement
    v'   = a,  p' = v                             a_0: of the last measured attitude
    V    = v + L a,  V_z = v_z + L_T a_z          velocity once all commands have taken effect

The balance b is what a downwash or a weak battery asked for; the vehicle may leave the downwash, so it is
forgotten. Wind is not modelled: its drift remains. Columns of a track, (n, 11): X, Y, VX, VY, AX, AY, YAW, Z,
VZ, AZ, BALANCE.

| symbol | name | meaning [unit] |
|---|---|---|
| p | X, Y, Z | position, world [m] |
| v | VX, VY, VZ | velocity, world [m/s] |
| a | AX, AY, AZ | acceleration, world [m/s^2] |
| phi theta psi | roll pitch yaw | commanded roll and pitch, last measured yaw [rad] |
| l | lift | commanded vertical acceleration [m/s^2] |
| b | BALANCE | lift at which a vehicle neither rises nor sinks [m/s^2] |
| T_h | hover_thrust | thrust of the weight [N] |
| L, L_T | LAG_S, THRUST_LAG_S | from a command to its tilt, to its thrust [s] |
| B | BALANCE_S | time in which the balance is learned, and forgotten [s] |
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_model.compiled import compiled
from q2q_model.geometry.rotations import rotate, yaw_from_quat
from q2q_model.signals.values import Array, SwarmCommand, SwarmState, TrackStatus
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY

THRUST_LAG_S = 0.026 + CRAZYFLIE_2_0.thrust_lag
"""From a command to its thrust [s]: camera and radio (settings), and the rotors (quadcopter)."""
LAG_S = THRUST_LAG_S + 0.12
"""From a command to its tilt [s]: that of the torque, and 2 zeta / w_n (attitude_law)."""
BALANCE_S = 0.5
"""Time in which the balance is learned and forgotten [s]: a vehicle at 0.5 m/s crosses a downwash in it."""
LIFT_MAX = 3.0
"""Largest lift that is learned or given to a vehicle without measurements [m/s^2]: less than the thrust of a
Crazyflie 2.0 leaves above its weight, and little beside that of a vehicle on the ground."""

TRACKED = int(TrackStatus.TRACKED)
"""Status of a measured vehicle."""
X, Y, VX, VY, AX, AY, YAW, Z, VZ, AZ, BALANCE = range(11)
ROLL, PITCH, LIFT = range(3)
"""Columns of what a command asks for [rad, rad, m/s^2]."""
UP = np.array([0.0, 0.0, 1.0])
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
UNKNOWN = np.array([np.nan, np.nan, 0.0, 0.0, 0.0, 0.0, 0.0, np.nan, 0.0, 0.0, 0.0])
"""Track of a vehicle that was never measured: at rest, position unknown."""


class Reckoned(NamedTuple):
    """Horizontal motion of a vehicle without measurements."""

    pos: Array
    """Position now [m], (2,)."""
    rest: Array
    """Position at which it comes to rest by braking [m], (2,)."""


class Sight(NamedTuple):
    """Tracks of a state, and which of them are measured."""

    track: Array
    """(n, 11)."""
    measured: NDArray[np.bool_]
    """(n,)."""


def is_measured(state: SwarmState) -> NDArray[np.bool_]:
    """Return which vehicles are measured, (n,): not by a sample that the filter does not trust yet."""
    return np.asarray(state.status == TRACKED)


def measured_tracks(state: SwarmState) -> Array:
    """Return the tracks of a state, (n, 11); AZ and BALANCE are those of a hover."""
    size = np.square(state.quat).sum(axis=1, keepdims=True)
    known = np.isfinite(size) & (size > 0.0)  # any message may come: no attitude is level
    acc = GRAVITY * rotate(np.where(known, state.quat, LEVEL), UP)[:, :2]
    yaw = yaw_from_quat(state.quat)[:, None]
    hover = np.zeros((len(acc), 2))
    heights = state.pos[:, 2:], state.vel[:, 2:]
    return np.concatenate((state.pos[:, :2], state.vel[:, :2], acc, yaw, *heights, hover), axis=1)


def asked(command: SwarmCommand, hover_thrust: float) -> Array:
    """Return roll, pitch [rad] and lift [m/s^2] of a command, (n, 3)."""
    upright = np.cos(command.roll) * np.cos(command.pitch)
    lift = GRAVITY * (command.thrust * upright / hover_thrust - 1.0)
    return np.stack((command.roll, command.pitch, lift), axis=1)


@compiled
def propagate(track: Array, given: Array, elapsed: float) -> None:
    """Propagate tracks (n, 11) in place by `elapsed` [s] under roll, pitch and lift (n, 3)."""
    decay = math.exp(-elapsed / LAG_S)
    for i in range(track.shape[0]):
        one, roll, pitch = track[i], given[i, ROLL], given[i, PITCH]
        ahead, aside = GRAVITY * math.sin(pitch) * math.cos(roll), -GRAVITY * math.sin(roll)
        cos, sin = math.cos(one[YAW]), math.sin(one[YAW])
        for k in range(2):
            aimed = cos * ahead - sin * aside if k == 0 else sin * ahead + cos * aside
            lacking = one[AX + k] - aimed
            before = one[VX + k]
            one[VX + k] += aimed * elapsed + lacking * LAG_S * (1.0 - decay)
            one[AX + k] = aimed + lacking * decay
            one[X + k] += 0.5 * elapsed * (before + one[VX + k])
        _propagate_height(one, given[i, LIFT], elapsed)


@compiled
def _propagate_height(one: Array, lift: float, elapsed: float) -> None:
    """Propagate the height of a track (11,) by `elapsed` [s]."""
    aimed, decay = lift - one[BALANCE], math.exp(-elapsed / THRUST_LAG_S)
    lacking, before = one[AZ] - aimed, one[VZ]
    one[VZ] += aimed * elapsed + lacking * THRUST_LAG_S * (1.0 - decay)
    one[AZ] = aimed + lacking * decay
    one[Z] += 0.5 * elapsed * (before + one[VZ])
    one[BALANCE] *= math.exp(-elapsed / BALANCE_S)
