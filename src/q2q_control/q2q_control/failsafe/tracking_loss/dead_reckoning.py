"""Motion of vehicles by their own commands, and the trim against what else moves them.

    a' = j,  j' = W^2 (u - a - L j)   u: acceleration that the command asks for; vertically a' = (u - a) / L_T
    v' = a + eta - b,  p' = v         eta: predicted downwash, 0 without a prediction
    V  = v + L (a + eta - b) + j/W^2  velocity once all commands have taken effect; vertically with L_T, no j

A tilt follows its command through camera and radio (d), the rotors (T) and the attitude loop (w_n, zeta,
attitude_law). Its second-order lag has the mean and the variance of their impulse response:

    L = d + T + 2 zeta / w_n          S^2 = T^2 + (2 zeta / w_n)^2 - 2 / w_n^2          W^2 = 2 / (L^2 - S^2)

While a vehicle is measured, p and v are its position and velocity, and a Luenberger observer with two poles
at -w, whose velocity is o, learns b. A weak battery, a wind, the tilt that a weak rotor costs, and a downwash
that is not predicted appear in b; an acceleration that the controller wants does not. A time k after the
first measurement the gains are those of a growing memory, where these are larger: b is the slope of a line
through all velocities so far (E. Brookner, Tracking and Kalman Filtering Made Easy, 1998, chapter 1), and
that b is 0 counts as much as those of the time L. With h between measurements:

    s = k^3 / (k^3 + L^3)             o += max(1 - e^(-2 w h), (1 + 3 s) h / k) (v - o)
                                      b -= max((1 - e^(-w h))^2 / h, 6 s h / k^2) (v - o)

For 2 L after a gap (elapsed_time) nothing is learned: what was in effect meanwhile is not known. Without
measurements the motion is integrated, with the trim of the last one. Thrust that b_z takes away is
taken for weak: horizontally u counts by 1 / (1 + b_z / g).

| symbol | name | meaning [unit] |
|---|---|---|
| p | POS | position, world [m] |
| v | VEL | velocity, world [m/s] |
| a | ACC | acceleration by commands, world [m/s^2] |
| j | JERK | its horizontal rate of change, world [m/s^3] |
| b | TRIM | trim acceleration: commanded acceleration that keeps the velocity constant, plus eta [m/s^2] |
| o | OBSERVED | velocity of the observer [m/s] |
| psi | YAW | last measured yaw [rad] |
| L, L_T | LAG_S, THRUST_LAG_S | from a command to its tilt, to its thrust, mean [s] |
| W^2 | TILT_SQUARE | squared natural frequency of a tilt behind its command [1/s^2] |
| w | OBSERVER | bandwidth of the observer [rad/s] |
| k | KNOWN_S | time for which the vehicle has been measured since the first time [s] |
| - | UNSETTLED | time until the tilt no longer depends on what was commanded before a gap [s] |
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_control.attitude.attitude_law import AttitudeParams
from q2q_control.attitude.command_delay import LATENCY_S
from q2q_model.compiled import compiled
from q2q_model.geometry.yaw import yaw_of
from q2q_model.signals.values import TRACKED, Array, Status
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY

THRUST_LAG_S = LATENCY_S + CRAZYFLIE_2_0.thrust_lag
"""From a command to its thrust [s]: camera, radio, and the rotors of a Crazyflie 2.0, for every vehicle."""
_LOOP = AttitudeParams()
_LOOP_S = 2.0 * _LOOP.damping / _LOOP.frequency
LAG_S = THRUST_LAG_S + _LOOP_S
"""From a command to its tilt [s]: that of the torque, and the attitude loop's."""
TILT_SQUARE = 2.0 / (LAG_S**2 - CRAZYFLIE_2_0.thrust_lag**2 - _LOOP_S**2 + 2.0 / _LOOP.frequency**2)
"""W^2 [1/s^2]."""
OBSERVER = 2.0, 8.0
"""Bandwidth of the trim, horizontal and vertical [rad/s]: below 1 / L and 1 / L_T; a gust is none."""
TRIM_MAX = 1.5, 3.0
"""Largest trim on an axis, horizontal and vertical, and largest lift of a vehicle without measurements
[m/s^2]: a tilt of 0.15 rad; less than the thrust of a Crazyflie 2.0 leaves above its weight. A vehicle on the
ground is in trim whatever it is commanded."""
OUTLIER_SPEED = 2.0
"""Error of the observed velocity that no disturbance makes: its track restarted [m/s]."""

POS, VEL, ACC, TRIM, YAW, SEEN, OBSERVED, JERK, KNOWN_S, UNSETTLED = 0, 3, 6, 9, 12, 13, 14, 17, 19, 20
"""Columns of a track, the first one of vectors; SEEN is 1 if its last tick measured the vehicle."""
TRACK_WIDTH = 21
UNKNOWN = np.array([math.nan] * 3 + [0.0] * (TRACK_WIDTH - 3))
"""Track of a vehicle that was never measured: at rest, position unknown."""


class AppliedCommand(NamedTuple):
    """Command in effect, (n,) each."""

    share: Array
    """Thrust over the weight [-]."""
    roll: Array
    """[rad]"""
    pitch: Array
    """[rad]"""


class MeasuredState(NamedTuple):
    """What a state shows of the vehicles."""

    pos: Array
    """Position [m], world, (n, 3)."""
    vel: Array
    """Velocity [m/s], world, (n, 3)."""
    quat: Array
    """Orientation xyzw, (n, 4)."""
    status: Status
    """TrackStatus, (n,)."""


@compiled
def reckon(track: Array, applied: AppliedCommand, eta: Array, dt: float, state: MeasuredState) -> int:
    """Advance tracks (n, TRACK_WIDTH) in place to a tick; return how many vehicles are not measured.

    A vehicle whose state is not finite counts as not measured.

    Args:
        track: of the last tick.
        applied: in effect since then.
        eta: predicted downwash [m/s^2], world, (n, 3); what is not finite counts as none.
        dt: time since the last tick [s].
        state: at the tick.
    """
    unmeasured = 0
    share, roll, pitch = applied
    pos, vel, quat, status = state
    for i in range(track.shape[0]):
        one, command = track[i], (share[i], roll[i], pitch[i])
        _propagate(one, command, eta[i], dt)
        measured = status[i] == TRACKED and abs(pos[i].sum() + vel[i].sum() + quat[i].sum()) < math.inf
        if measured:
            _correct(one, pos[i], vel[i], dt)
            one[YAW] = yaw_of(quat[i, 0], quat[i, 1], quat[i, 2], quat[i, 3])
        one[SEEN] = 1.0 if measured else 0.0
        unmeasured += not measured
    return unmeasured


@compiled
def _propagate(one: Array, command: tuple[float, float, float], eta: Array, dt: float) -> None:
    """Propagate a track (TRACK_WIDTH,) by `dt` [s] under a share of the hover thrust, roll and pitch."""
    share, roll, pitch = command
    one[UNSETTLED] = max(one[UNSETTLED] - dt, 0.0)
    level = GRAVITY * share / (1.0 + one[TRIM + 2] / GRAVITY)  # a weak rotor or battery gives less
    ahead, aside = level * math.sin(pitch) * math.cos(roll), -level * math.sin(roll)
    cos, sin = math.cos(one[YAW]), math.sin(one[YAW])
    lift = GRAVITY * (share * math.cos(roll) * math.cos(pitch) - 1.0)
    for k, aimed in enumerate((cos * ahead - sin * aside, sin * ahead + cos * aside, lift)):
        lacking, before = one[ACC + k] - aimed, one[VEL + k]
        if k < 2:
            left, one[JERK + k], made = _tilted(lacking, one[JERK + k], dt)
        else:
            left = lacking * math.exp(-dt / THRUST_LAG_S)
            made = THRUST_LAG_S * (lacking - left)
        felt = eta[k] if abs(eta[k]) < math.inf else 0.0
        gained = (aimed + felt - one[TRIM + k]) * dt + made
        one[VEL + k] += gained
        one[OBSERVED + k] += gained
        one[ACC + k] = aimed + left
        one[POS + k] += 0.5 * dt * (before + one[VEL + k])


@compiled
def _tilted(lacking: float, jerk: float, dt: float) -> tuple[float, float, float]:
    """Return a - u and j after `dt` [s], and the integral of a - u, for a constant u."""
    decay = 0.5 * LAG_S * TILT_SQUARE
    turn = math.sqrt(TILT_SQUARE - decay * decay)
    fading = math.exp(-decay * dt)
    cos, sin = fading * math.cos(turn * dt), fading * math.sin(turn * dt) / turn
    left = lacking * (cos + decay * sin) + jerk * sin
    after = jerk * (cos - decay * sin) - TILT_SQUARE * lacking * sin
    return left, after, LAG_S * (lacking - left) + (jerk - after) / TILT_SQUARE


@compiled
def _correct(one: Array, pos: Array, vel: Array, dt: float) -> None:
    """Correct a track by a measurement `dt` [s] after the last one; begin it if it was lost."""
    one[KNOWN_S] += dt * one[SEEN]
    for k in range(3):
        error = vel[k] - one[OBSERVED + k]
        one[POS + k], one[VEL + k] = pos[k], vel[k]
        if one[SEEN] == 0.0 or one[UNSETTLED] > 0.0 or not abs(error) < OUTLIER_SPEED:
            one[OBSERVED + k] = vel[k]
        elif dt > 0.0:
            observed, learned = _gains(OBSERVER[k // 2], dt, one[KNOWN_S])
            trim, most = one[TRIM + k] - learned * error, TRIM_MAX[k // 2]
            one[OBSERVED + k] += observed * error
            one[TRIM + k] = min(max(trim, -most), most)


@compiled
def _gains(bandwidth: float, dt: float, known: float) -> tuple[float, float]:
    """Return the gains of the observed velocity [-] and of the trim [1/s], `known` [s] after the first."""
    fast, sure = math.exp(-bandwidth * dt), known**3 / (known**3 + LAG_S**3)
    observed = max(1.0 - fast * fast, (1.0 + 3.0 * sure) * dt / known)
    return observed, max((1.0 - fast) ** 2 / dt, 6.0 * sure * dt / known**2)
