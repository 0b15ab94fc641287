"""Thrust and tilt that brake vehicles without measurements.

A level vehicle keeps its speed: at 1 m/s it has moved by 1 m after a second. The velocity V of an unmeasured
vehicle, once all its commands have taken effect (dead_reckoning), is braked:

    a = b - eta - V / tau                         horizontal, |a| <= a_max, instead of level attitude
    a_z = b_z - eta_z - V_z / tau                 |a_z| <= b_max
    T = (T_fallback + m a_z) / (cos phi cos theta)

A vehicle that lands is kept from rising and from sinking fast: V_z counts where it is above 0 or below
-v_max, and v_max + (1 - land_share) g tau is the fastest, TOUCHDOWN_MAX.

| symbol | name | meaning [unit] |
|---|---|---|
| tau | BRAKING_S | time constant of braking [s] |
| a_max | BRAKING_MAX | largest horizontal acceleration [m/s^2] |
| v_max | SINK_MAX | velocity of sinking from which it is braked [m/s] |
| b_max | TRIM_MAX | largest change of the lift [m/s^2] (dead_reckoning) |
| b | TRIM | trim acceleration, plus eta [m/s^2] (dead_reckoning) |
| eta | eta | predicted downwash [m/s^2] |
"""

from typing import NamedTuple

import numpy as np

from q2q_control.failsafe.tracking_loss.dead_reckoning import (
    ACC,
    JERK,
    LAG_S,
    POS,
    THRUST_LAG_S,
    TILT_SQUARE,
    TRIM,
    TRIM_MAX,
    VEL,
    YAW,
)
from q2q_model.signals.values import Array, CommandStatus, SwarmCommand
from q2q_model.vehicle.constants import GRAVITY

BRAKING_S = 0.5
"""Time constant of braking [s]: more than two lags."""
BRAKING_MAX = 3.5
"""Largest deceleration [m/s^2]: TILT_MAX at hover thrust gives 3.58 (q2q_model.vehicle.attitude_limits)."""
SINK_MAX = 0.8
"""Velocity of sinking from which a landing vehicle brakes [m/s]."""
TOUCHDOWN_MAX = 1.1
"""Largest velocity of sinking at which it touches down [m/s]: SINK_MAX + (1 - land_share) g BRAKING_S."""


class ReckonedMotions(NamedTuple):
    """Dead-reckoned motions of vehicles."""

    track: Array
    """(n, TRACK_WIDTH) (dead_reckoning)."""
    eta: Array
    """Predicted downwash [m/s^2], world, (n, 3)."""


def braking_thrust(motions: ReckonedMotions, command: SwarmCommand, hover_thrust: float) -> Array:
    """Return the thrust [N] that keeps level vehicles at their height, and lets those sink that land, (n,).

    Args:
        motions: of the vehicles of the command.
        command: with the thrust and the status of the fallback.
        hover_thrust: of one vehicle [N].
    """
    rising = _coming(motions)[:, 2]
    landing = np.maximum(rising, 0.0) + np.minimum(rising + SINK_MAX, 0.0)
    rising = np.where(command.status == CommandStatus.LAND, landing, rising)
    most = TRIM_MAX[1]
    lift = np.clip(_trim(motions)[:, 2] - rising / BRAKING_S, -most, most)
    return np.asarray(command.thrust + hover_thrust * lift / GRAVITY)


def braking_tilt(motions: ReckonedMotions) -> tuple[Array, Array]:
    """Return roll and pitch [rad] that brake each vehicle, (n,) each."""
    acc = (_trim(motions) - _coming(motions) / BRAKING_S)[:, :2]
    acc *= np.minimum(1.0, BRAKING_MAX / np.maximum(np.linalg.norm(acc, axis=1), 1e-9))[:, None]
    yaw = motions.track[:, YAW]
    ahead = np.cos(yaw) * acc[:, 0] + np.sin(yaw) * acc[:, 1]
    aside = -np.sin(yaw) * acc[:, 0] + np.cos(yaw) * acc[:, 1]
    return np.arctan(-aside / GRAVITY), np.arctan(ahead / GRAVITY)


def resting_places(motions: ReckonedMotions) -> Array:
    """Return where vehicles come to rest by braking [m], world, (n, 2)."""
    coming = _coming(motions)[:, :2]
    speed = np.linalg.norm(coming, axis=1, keepdims=True)
    # at BRAKING_MAX down to the speed from which it decays within BRAKING_S
    fast = np.maximum(speed - BRAKING_MAX * BRAKING_S, 0.0)
    time = LAG_S + BRAKING_S + 0.5 * fast**2 / BRAKING_MAX / np.maximum(speed, 1e-9)
    return np.asarray(motions.track[:, POS : POS + 2] + time * coming)


def _trim(motions: ReckonedMotions) -> Array:
    """Return the commanded accelerations that keep the velocities constant [m/s^2], world, (n, 3)."""
    return np.asarray(motions.track[:, TRIM : TRIM + 3] - motions.eta)


def _coming(motions: ReckonedMotions) -> Array:
    """Return the velocities once all commands have taken effect [m/s], world, (n, 3)."""
    track, lag = motions.track, np.array([LAG_S, LAG_S, THRUST_LAG_S])
    coming = track[:, VEL : VEL + 3] + lag * (track[:, ACC : ACC + 3] - _trim(motions))
    coming[:, :2] += track[:, JERK : JERK + 2] / TILT_SQUARE
    return np.asarray(coming)
