"""Brake vehicles without measurements, on velocities dead-reckoned from their own commands.

A level vehicle keeps its speed: at 1 m/s it has moved by 1 m after a second. The velocity V of an unmeasured
vehicle, once all its commands have taken effect (q2q_control.failsafe.dead_reckoning), is braked:

    a = -V / tau,  |a| <= a_max                   horizontal, commanded instead of level attitude
    a_z = -V_z / tau + b,  |a_z| <= a_lift        T = (T_fallback + m a_z) / (cos phi cos theta)

A vehicle that lands is not kept from sinking: V_z counts upwards only. While the controller still flies an
unmeasured vehicle on a predicted state, it gets the dead-reckoned position and velocity: a filter, which
knows no commands, predicts straight on.

| symbol | name | meaning [unit] |
|---|---|---|
| tau | BRAKING_S | time constant of braking [s] |
| a_max | BRAKING_MAX | largest deceleration [m/s^2] |
| a_lift | LIFT_MAX | largest change of the lift [m/s^2] |
| b | balance | lift at which the vehicle neither rose nor sank [m/s^2] (dead_reckoning) |
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from q2q_control.failsafe.dead_reckoning import (
    AX,
    AY,
    AZ,
    BALANCE,
    LAG_S,
    LIFT,
    LIFT_MAX,
    THRUST_LAG_S,
    UNKNOWN,
    VX,
    VY,
    VZ,
    YAW,
    Reckoned,
    Sight,
    X,
    Y,
    Z,
    asked,
    is_measured,
    measured_tracks,
    propagate,
)
from q2q_control.failsafe.ladder import is_blind
from q2q_model.signals.values import Array, CommandStatus, Names, SwarmCommand, SwarmState, index_of
from q2q_model.vehicle.constants import GRAVITY

BRAKING_S = 0.5
"""Time constant of braking [s]: more than two lags."""
BRAKING_MAX = 3.5
"""Largest deceleration [m/s^2]: a tilt of 0.35 rad, the largest that the controllers command."""
LONGEST_STEP = 0.1
"""Longest time between ticks for which the last tilt is integrated [s]."""


class DeadReckonedBraking:
    """Dead-reckoned positions and velocities of unmeasured vehicles."""

    def __init__(self, hover_thrust: float) -> None:
        """Brake vehicles of a `hover_thrust` [N]."""
        self._hover_thrust = hover_thrust
        self.reset()

    def reset(self) -> None:
        """Forget all vehicles."""
        self._names: Names = ()
        self._track = np.zeros((0, len(UNKNOWN)))
        self._given = np.zeros((0, 3))  # roll, pitch, lift of the last tick
        self._t = math.inf

    def reckoned(self, names: Names) -> dict[str, Reckoned]:
        """Return the dead-reckoned horizontal motions of those of the named vehicles that are known."""
        rows = [row for row in index_of(names, self._names) if row >= 0]
        pos, coming = self._track[rows, X : Y + 1], self._coming()[rows]
        speed = np.linalg.norm(coming, axis=1, keepdims=True)
        # at BRAKING_MAX down to the speed from which it decays within BRAKING_S
        fast = np.maximum(speed - BRAKING_MAX * BRAKING_S, 0.0)
        time = LAG_S + BRAKING_S + 0.5 * fast**2 / BRAKING_MAX / np.maximum(speed, 1e-9)
        rest = pos + time * coming
        return {self._names[row]: Reckoned(*one) for row, *one in zip(rows, pos, rest, strict=True)}

    def record_measured(self, state: SwarmState, command: SwarmCommand, balance: Array) -> None:
        """Record a tick in which every vehicle was measured, its command, and the balances (n,) of that."""
        self._names, self._track = state.names, measured_tracks(state)
        given = np.column_stack((asked(command, self._hover_thrust), balance))
        given = _of(given, command.names, state.names, 0.0)
        self._begin(given[:, : LIFT + 1], given[:, LIFT + 1], np.ones(len(given), dtype=np.bool_))
        self._t = command.t

    def predicted(self, state: SwarmState) -> SwarmState:
        """Return the state with dead-reckoned positions and velocities where vehicles are not measured."""
        track = _of(self._propagated(self._names, state.t), self._names, state.names, UNKNOWN)
        rows = ~is_measured(state) & np.isfinite(track[:, X])
        if not rows.any():
            return state
        pos, vel = state.pos.copy(), state.vel.copy()
        pos[rows], vel[rows] = track[rows][:, (X, Y, Z)], track[rows][:, (VX, VY, VZ)]
        return replace(state, pos=pos, vel=vel)

    def update(self, state: SwarmState | None, command: SwarmCommand, balance: Array) -> SwarmCommand:
        """Return the command with unmeasured vehicles braking instead of flying level.

        Args:
            state: of the tick; None means that no vehicle was measured.
            command: with fallbacks.
            balance: of each vehicle when it was last measured [m/s^2], (n,).
        """
        names, sight = command.names, _sight(state, command.names)
        measured = sight.measured
        self._track = np.where(measured[:, None], sight.track, self._propagated(names, command.t))
        self._names = names
        braking = ~measured & is_blind(command.status)
        if braking.any():
            roll, pitch = self._tilt()
            thrust = self._thrust(command) / (np.cos(roll) * np.cos(pitch))
            command = replace(
                command,
                thrust=np.where(braking, thrust, command.thrust),
                roll=np.where(braking, roll, command.roll),
                pitch=np.where(braking, pitch, command.pitch),
            )
        self._begin(asked(command, self._hover_thrust), balance, measured)
        self._t = command.t
        return command

    def _begin(self, given: Array, balance: Array, measured: NDArray[np.bool_]) -> None:
        """Take what is asked of the vehicles (n, 3); measured ones do it already, with their balance."""
        self._given = given
        self._track[measured, BALANCE] = balance[measured]
        self._track[measured, AZ] = (given[:, LIFT] - balance)[measured]

    def _thrust(self, command: SwarmCommand) -> Array:
        """Return the thrust [N] that keeps vehicles level at their height, and lets those sink that land."""
        rising = self._track[:, VZ] + THRUST_LAG_S * self._track[:, AZ]
        rising = np.where(command.status == CommandStatus.LAND, np.maximum(rising, 0.0), rising)
        lift = np.clip(self._track[:, BALANCE] - rising / BRAKING_S, -LIFT_MAX, LIFT_MAX)
        return np.asarray(command.thrust + self._hover_thrust * lift / GRAVITY)

    def _propagated(self, names: Names, t: float) -> Array:
        """Return the tracks at time t [s], (n, 11)."""
        track = _of(self._track, self._names, names, UNKNOWN).copy()
        elapsed = min(max(t - self._t, 0.0), LONGEST_STEP)
        propagate(track, _of(self._given, self._names, names, 0.0), elapsed)
        return track

    def _coming(self) -> Array:
        """Return the velocity once all commands have taken effect [m/s], (n, 2)."""
        return self._track[:, VX : VY + 1] + LAG_S * self._track[:, AX : AY + 1]

    def _tilt(self) -> tuple[Array, Array]:
        """Return roll and pitch [rad] that brake each vehicle, (n,) each."""
        coming, yaw = self._coming(), self._track[:, YAW]
        speed = np.linalg.norm(coming, axis=1)
        gain = np.minimum(1.0 / BRAKING_S, BRAKING_MAX / np.maximum(speed, 1e-9))
        acc = -gain[:, None] * coming
        ahead = np.cos(yaw) * acc[:, 0] + np.sin(yaw) * acc[:, 1]
        aside = -np.sin(yaw) * acc[:, 0] + np.cos(yaw) * acc[:, 1]
        return np.arctan(-aside / GRAVITY), np.arctan(ahead / GRAVITY)


def _sight(state: SwarmState | None, names: Names) -> Sight:
    """Return what a state shows of the vehicles."""
    if state is None:
        return Sight(np.tile(UNKNOWN, (len(names), 1)), np.zeros(len(names), np.bool_))
    measured = np.append(is_measured(state), False)[index_of(names, state.names)]
    return Sight(_of(measured_tracks(state), state.names, names, UNKNOWN), measured)


def _of(values: Array, known: Names, names: Names, missing: float | Array) -> Array:
    """Return the rows of `names`, (n, m); `missing` where a name is unknown."""
    if names == known:
        return values
    absent = np.broadcast_to(missing, (1, values.shape[1]))
    return np.asarray(np.concatenate([values, absent])[index_of(names, known)])
