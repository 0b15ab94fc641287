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

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from q2q_model.rotations import yaw_from_quat
from q2q_model.signals import Array, CommandStatus, Names, SwarmCommand, SwarmState, index_of
from q2q_model.vehicle import GRAVITY

LAG_S = 0.15
"""From a command to its tilt [s]: 26 ms of camera and radio, 2 zeta / w_n = 0.12 s (q2q_control.attitude)."""
BRAKING_S = 0.5
"""Time constant of braking [s]: three lags."""
BRAKING_MAX = 2.0
"""Largest deceleration [m/s^2]: a tilt of 0.2 rad, which costs 2 % of lift."""
LONGEST_STEP = 0.1
"""A longer time between ticks is no time in which the last tilt was flown [s]."""
_BRAKING = (CommandStatus.LEVEL, CommandStatus.LAND)


class BlindBraking:
    """Hold how fast vehicles fly that are not seen."""

    def __init__(self) -> None:
        """Know nobody."""
        self.reset()

    def reset(self) -> None:
        """Forget all vehicles."""
        self._names: Names = ()
        self._pos = np.zeros((0, 2))
        self._vel = np.zeros((0, 2))
        self._yaw = np.zeros(0)
        self._last: SwarmCommand | None = None

    @property
    def places(self) -> dict[str, Array]:
        """Return where vehicles are, seen or reckoned, horizontally [m], (2,) each."""
        return dict(zip(self._names, self._pos, strict=True))

    def sighted(self, state: SwarmState, command: SwarmCommand) -> None:
        """Note a tick in which every vehicle was seen, and what it was commanded."""
        self._names, self._pos = state.names, state.pos[:, :2].copy()
        self._vel, self._yaw = state.vel[:, :2], yaw_from_quat(state.quat)
        self._vel = self._vel + self._gained(command, state.names, LAG_S)
        self._last = command

    def update(self, state: SwarmState | None, command: SwarmCommand) -> SwarmCommand:
        """Return the command in which unseen vehicles brake where they would be level.

        Without a state nobody is seen.
        """
        seen = np.zeros(len(command.names), dtype=np.bool_)
        if state is not None:
            seen = self._of(state.age, state.names, command.names, np.inf) <= 0.0
        self._reckon(command)
        if state is not None and seen.any():
            self._correct(state, command, seen)
        braking = ~seen & np.isin(command.status, _BRAKING)
        if braking.any():
            roll, pitch = self._tilt()
            command = replace(
                command,
                roll=np.where(braking, roll, command.roll),
                pitch=np.where(braking, pitch, command.pitch),
            )
        self._last = command
        return command

    def _reckon(self, command: SwarmCommand) -> None:
        """Move everybody on to the tick of a command."""
        names = command.names
        self._pos = self._of(self._pos, self._names, names, np.nan)
        self._vel = self._of(self._vel, self._names, names, 0.0)
        self._yaw = self._of(self._yaw, self._names, names, 0.0)
        self._names = names
        if self._last is not None:
            elapsed = min(max(command.t - self._last.t, 0.0), LONGEST_STEP)
            self._pos = self._pos + elapsed * self._vel
            self._vel = self._vel + self._gained(self._last, names, elapsed)

    def _correct(self, state: SwarmState, command: SwarmCommand, seen: NDArray[np.bool_]) -> None:
        """Take over what is seen of vehicles."""
        rows = index_of(command.names, state.names)[seen]
        self._pos[seen], self._vel[seen] = state.pos[rows, :2], state.vel[rows, :2]
        self._yaw[seen] = yaw_from_quat(state.quat[rows])
        self._vel[seen] += self._gained(command, command.names, LAG_S)[seen]

    def _gained(self, command: SwarmCommand, names: Names, elapsed: float) -> Array:
        """Return the velocity that a command gives in a time [s], (n, 2)."""
        roll, pitch = (self._of(one, command.names, names, 0.0) for one in (command.roll, command.pitch))
        return GRAVITY * elapsed * _leaning(roll, pitch, self._yaw)

    def _tilt(self) -> tuple[Array, Array]:
        """Return roll and pitch [rad] that take the velocity away, (n,) each."""
        speed = np.linalg.norm(self._vel, axis=1)
        gain = np.minimum(1.0 / BRAKING_S, BRAKING_MAX / np.maximum(speed, 1e-9))
        acc = -gain[:, None] * self._vel
        ahead = np.cos(self._yaw) * acc[:, 0] + np.sin(self._yaw) * acc[:, 1]
        aside = -np.sin(self._yaw) * acc[:, 0] + np.cos(self._yaw) * acc[:, 1]
        return np.arctan(-aside / GRAVITY), np.arctan(ahead / GRAVITY)

    @staticmethod
    def _of(values: Array, known: Names, names: Names, missing: float) -> Array:
        """Return the rows of `names`, `missing` for those that are not known."""
        if names == known:
            return values
        absent = np.full((1, *values.shape[1:]), missing)
        return np.asarray(np.concatenate([values, absent])[index_of(names, known)])


def _leaning(roll: Array, pitch: Array, yaw: Array) -> Array:
    """Return the horizontal part of the body's z axis, world, (n, 2)."""
    ahead, aside = np.sin(pitch) * np.cos(roll), -np.sin(roll)
    return np.stack(
        [np.cos(yaw) * ahead - np.sin(yaw) * aside, np.sin(yaw) * ahead + np.cos(yaw) * aside], axis=1
    )
