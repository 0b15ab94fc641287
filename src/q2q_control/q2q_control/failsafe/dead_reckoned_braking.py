"""Brake vehicles without measurements, on velocities dead-reckoned from their own commands.

A level vehicle keeps its speed: at 1 m/s it has moved by 1 m after a second. The horizontal velocity of an
unmeasured vehicle is integrated from the last accepted estimate and the commanded tilts, and braked:

    v_0     = v_est + g u(phi_0, theta_0, psi) L          commands still in the lag at the last measurement
    v_(k+1) = v_k + g u(phi_k, theta_k, psi) dt           u: horizontal part of the body's z axis
    a       = -v / tau,  |a| <= a_max                     commanded instead of level attitude
    p_(k+1) = p_k + v_k dt                                dead-reckoned position

So v is the velocity once all commands have taken effect. Wind is not modelled: its drift remains.

| symbol | name | meaning [unit] |
|---|---|---|
| p | pos | horizontal position, world [m], (n, 2) |
| v | vel | horizontal velocity, world [m/s], (n, 2) |
| phi theta psi | roll pitch yaw | commanded roll and pitch, last measured yaw [rad] |
| L | LAG_S | from a command to its tilt [s] |
| tau | BRAKING_S | time constant of braking [s] |
| a_max | BRAKING_MAX | largest deceleration [m/s^2] |
"""

import math
from dataclasses import replace

import numpy as np

from q2q_control.failsafe.ladder import is_blind
from q2q_model.compiled import compiled
from q2q_model.geometry.rotations import yaw_from_quat
from q2q_model.signals.values import Array, Names, SwarmCommand, SwarmState, index_of
from q2q_model.vehicle.constants import GRAVITY

LAG_S = 0.15
"""From a command to its tilt [s]: 26 ms of camera and radio, 2 zeta / w_n = 0.12 s (attitude_law)."""
BRAKING_S = 0.5
"""Time constant of braking [s]: three lags."""
BRAKING_MAX = 2.0
"""Largest deceleration [m/s^2]: a tilt of 0.2 rad, which costs 2 % of the vertical thrust."""
LONGEST_STEP = 0.1
"""Longest time between ticks for which the last tilt is integrated [s]."""

_X, _Y, _VX, _VY, _YAW = range(5)
_UNKNOWN = np.array([np.nan, np.nan, 0.0, 0.0, 0.0])
_AGE = 5
"""Column of a measurement, after the columns of a track."""


class DeadReckonedBraking:
    """Dead-reckoned positions and velocities of unmeasured vehicles."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all vehicles."""
        self._names: Names = ()
        self._track = np.zeros((0, 5))  # p, v, psi
        self._given = np.zeros((0, 2))  # phi, theta of the last tick
        self._t = math.inf

    @property
    def positions(self) -> dict[str, Array]:
        """Return the horizontal position of each vehicle, measured or dead-reckoned [m], (2,)."""
        return dict(zip(self._names, self._track[:, :2], strict=True))

    def record_measured(self, state: SwarmState, command: SwarmCommand) -> None:
        """Record a tick in which every vehicle was measured, and its command."""
        self._names, self._track = state.names, np.zeros((len(state.names), 5))
        given = _of(_tilts(command), command.names, state.names, 0.0)
        sight = _sight(state, state.names)
        sight[:, _AGE] = 0.0
        _propagate(self._track, given, 0.0, sight, given)
        self._given, self._t = given, command.t

    def update(self, state: SwarmState | None, command: SwarmCommand) -> SwarmCommand:
        """Return the command with unmeasured vehicles braking instead of flying level.

        `state` None means that no vehicle was measured.
        """
        names, sight = command.names, _sight(state, command.names)
        track = _of(self._track, self._names, names, _UNKNOWN)
        flown = _of(self._given, self._names, names, 0.0)
        elapsed = min(max(command.t - self._t, 0.0), LONGEST_STEP)
        _propagate(track, flown, elapsed, sight, _tilts(command))
        self._names, self._track = names, track
        braking = ~(sight[:, _AGE] <= 0.0) & is_blind(command.status)
        if braking.any():
            roll, pitch = self._tilt()
            command = replace(
                command,
                roll=np.where(braking, roll, command.roll),
                pitch=np.where(braking, pitch, command.pitch),
            )
        self._given, self._t = _tilts(command), command.t
        return command

    def _tilt(self) -> tuple[Array, Array]:
        """Return roll and pitch [rad] that brake each vehicle, (n,) each."""
        vel, yaw = self._track[:, _VX : _VY + 1], self._track[:, _YAW]
        speed = np.linalg.norm(vel, axis=1)
        gain = np.minimum(1.0 / BRAKING_S, BRAKING_MAX / np.maximum(speed, 1e-9))
        acc = -gain[:, None] * vel
        ahead = np.cos(yaw) * acc[:, 0] + np.sin(yaw) * acc[:, 1]
        aside = -np.sin(yaw) * acc[:, 0] + np.cos(yaw) * acc[:, 1]
        return np.arctan(-aside / GRAVITY), np.arctan(ahead / GRAVITY)


def _tilts(command: SwarmCommand) -> Array:
    """Return phi and theta [rad], (n, 2)."""
    return np.stack((command.roll, command.pitch), axis=1)


def _sight(state: SwarmState | None, names: Names) -> Array:
    """Return measured p, v, psi and age, (n, 6); infinite where a vehicle is not in the state."""
    if state is None:
        return np.full((len(names), _AGE + 1), np.inf)
    yaw = yaw_from_quat(state.quat)
    seen = np.concatenate((state.pos[:, :2], state.vel[:, :2], np.stack((yaw, state.age), axis=1)), axis=1)
    return _of(seen, state.names, names, np.inf)


def _of(values: Array, known: Names, names: Names, missing: float | Array) -> Array:
    """Return the rows of `names`, (n, m); `missing` where a name is unknown."""
    if names == known:
        return values
    absent = np.broadcast_to(missing, (1, values.shape[1]))
    return np.asarray(np.concatenate([values, absent])[index_of(names, known)])


@compiled
def _apply_tilt(one: Array, roll: float, pitch: float, elapsed: float) -> None:
    """Add the velocity that a tilt gives within `elapsed` [s]."""
    ahead, aside = math.sin(pitch) * math.cos(roll), -math.sin(roll)
    cos, sin = math.cos(one[_YAW]), math.sin(one[_YAW])
    one[_VX] += GRAVITY * elapsed * (cos * ahead - sin * aside)
    one[_VY] += GRAVITY * elapsed * (sin * ahead + cos * aside)


@compiled
def _propagate(track: Array, flown: Array, elapsed: float, sight: Array, given: Array) -> None:
    """Propagate `track` (n, 5) by `elapsed` [s] under the tilts `flown` (n, 2).

    Rows measured in `sight` (n, 6) are overwritten, with the tilts `given` (n, 2) still in the lag.
    """
    for i in range(track.shape[0]):
        one, seen = track[i], sight[i]
        one[_X] += elapsed * one[_VX]
        one[_Y] += elapsed * one[_VY]
        _apply_tilt(one, flown[i, 0], flown[i, 1], elapsed)
        if seen[_AGE] <= 0.0:
            one[:] = seen[:_AGE]
            _apply_tilt(one, given[i, 0], given[i, 1], LAG_S)
