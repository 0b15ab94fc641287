"""Brake vehicles that nobody sees, by what their own commands must have done to them since they were seen.

A level vehicle keeps the speed it had: at 1 m/s it is out of its place in a second. The horizontal velocity
of an unseen vehicle is reckoned from its last believed one and the tilts it was given, and taken away:

    v_0     = v_seen + g u(phi_0, theta_0, psi) L         what was on its way when it was seen last
    v_(k+1) = v_k + g u(phi_k, theta_k, psi) dt           u: horizontal part of the body's z axis
    a       = -v / tau,  |a| <= a_max                     what is commanded in place of level
    p_(k+1) = p_k + v_k dt                                where it is taken to be

So v is the velocity that will be once all commands are flown. What the air does is unknown: a drift stays.

| symbol | name | meaning [unit] |
|---|---|---|
| p | pos | horizontal position, world [m], (n, 2) |
| v | vel | horizontal velocity, world [m/s], (n, 2) |
| phi theta psi | roll pitch yaw | attitude commanded, yaw last seen [rad] |
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
"""Largest deceleration [m/s^2]: a tilt of 0.2 rad, which costs 2 % of lift."""
LONGEST_STEP = 0.1
"""A longer time between ticks is no time in which the last tilt was flown [s]."""

_X, _Y, _VX, _VY, _YAW = range(5)
_UNKNOWN = np.array([np.nan, np.nan, 0.0, 0.0, 0.0])
_AGE = 5
"""Column of what is seen, behind those of a track."""


class DeadReckonedBraking:
    """Dead-reckoned velocities of vehicles that are not seen."""

    def __init__(self) -> None:
        """Know nobody."""
        self.reset()

    def reset(self) -> None:
        """Forget all vehicles."""
        self._names: Names = ()
        self._track = np.zeros((0, 5))  # p, v, psi
        self._given = np.zeros((0, 2))  # phi, theta of the last tick
        self._t = math.inf

    @property
    def places(self) -> dict[str, Array]:
        """Return where vehicles are, seen or reckoned, horizontally [m], (2,) each."""
        return dict(zip(self._names, self._track[:, :2], strict=True))

    def sighted(self, state: SwarmState, command: SwarmCommand) -> None:
        """Note a tick in which every vehicle was seen, and what it was commanded."""
        self._names, self._track = state.names, np.zeros((len(state.names), 5))
        given = _of(_tilts(command), command.names, state.names, 0.0)
        sight = _sight(state, state.names)
        sight[:, _AGE] = 0.0
        follow(self._track, given, 0.0, sight, given)
        self._given, self._t = given, command.t

    def update(self, state: SwarmState | None, command: SwarmCommand) -> SwarmCommand:
        """Return the command in which unseen vehicles brake where they would be level.

        Without a state nobody is seen.
        """
        names, sight = command.names, _sight(state, command.names)
        track = _of(self._track, self._names, names, _UNKNOWN)
        flown = _of(self._given, self._names, names, 0.0)
        elapsed = min(max(command.t - self._t, 0.0), LONGEST_STEP)
        follow(track, flown, elapsed, sight, _tilts(command))
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
        """Return roll and pitch [rad] that take the velocity away, (n,) each."""
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
    """Return p, v, psi and age of vehicles as they are seen, (n, 6); infinite for who is not known."""
    if state is None:
        return np.full((len(names), _AGE + 1), np.inf)
    yaw = yaw_from_quat(state.quat)
    seen = np.concatenate((state.pos[:, :2], state.vel[:, :2], np.stack((yaw, state.age), axis=1)), axis=1)
    return _of(seen, state.names, names, np.inf)


def _of(values: Array, known: Names, names: Names, missing: float | Array) -> Array:
    """Return the rows of `names`, (n, m), `missing` for those that are not known."""
    if names == known:
        return values
    absent = np.broadcast_to(missing, (1, values.shape[1]))
    return np.asarray(np.concatenate([values, absent])[index_of(names, known)])


def _lean(one: Array, roll: float, pitch: float, elapsed: float) -> None:
    """Add what a tilt does to a vehicle's velocity in a time [s]."""
    ahead, aside = math.sin(pitch) * math.cos(roll), -math.sin(roll)
    cos, sin = math.cos(one[_YAW]), math.sin(one[_YAW])
    one[_VX] += GRAVITY * elapsed * (cos * ahead - sin * aside)
    one[_VY] += GRAVITY * elapsed * (sin * ahead + cos * aside)


def _follow(track: Array, flown: Array, elapsed: float, sight: Array, given: Array) -> None:
    for i in range(track.shape[0]):
        one, seen = track[i], sight[i]
        one[_X] += elapsed * one[_VX]
        one[_Y] += elapsed * one[_VY]
        lean(one, flown[i, 0], flown[i, 1], elapsed)
        if seen[_AGE] <= 0.0:
            one[:] = seen[:_AGE]
            lean(one, given[i, 0], given[i, 1], LAG_S)


lean, follow = compiled(_lean), compiled(_follow)
"""Move `track` (n, 5) on by `elapsed` [s] of the tilts `flown` (n, 2), then take over who is seen in `sight`
(n, 6), with the tilts `given` (n, 2) on their way."""
