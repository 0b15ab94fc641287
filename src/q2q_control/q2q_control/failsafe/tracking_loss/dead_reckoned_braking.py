"""Dead reckoning of all vehicles of a controller, and braking of those without measurements.

The motion of every vehicle is integrated from its commands (dead_reckoning); one without measurements flies
by braking_law instead of level. While the controller still flies it on a predicted state, it gets the
dead-reckoned position and velocity: a filter, which knows no commands, predicts straight on. A downwash that
is predicted is so for a lost vehicle where it was last; what is not predicted of it is in the trim. Both
fade with time, and as others move from above it (fading_downwash).
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_control.failsafe.tracking_loss.braking_law import (
    ReckonedMotions,
    braking_thrust,
    braking_tilt,
    resting_places,
)
from q2q_control.failsafe.tracking_loss.dead_reckoning import (
    LAG_S,
    POS,
    SEEN,
    TRIM,
    UNKNOWN,
    UNSETTLED,
    VEL,
    AppliedCommand,
    MeasuredState,
    reckon,
)
from q2q_control.failsafe.tracking_loss.elapsed_time import GAP_S, ElapsedTime
from q2q_control.failsafe.tracking_loss.fading_downwash import FadingDownwash, Places
from q2q_model.signals.values import (
    LAND,
    LEVEL,
    LOST,
    TRACKED,
    Array,
    Interference,
    Names,
    Status,
    SwarmCommand,
    SwarmState,
    index_of,
    predicted_eta,
    rows_by_name,
)


class Reckoned(NamedTuple):
    """Horizontal motion of a vehicle without measurements."""

    pos: Array
    """Position now [m], (2,)."""
    rest: Array
    """Position at which it comes to rest by braking [m], (2,)."""


class DeadReckonedBraking:
    """Motions of all vehicles by their commands; those of unmeasured ones are braked."""

    def __init__(self, hover_thrust: float) -> None:
        """Brake vehicles of a `hover_thrust` [N]."""
        self._hover_thrust = hover_thrust
        self.reset()

    def reset(self) -> None:
        """Forget all vehicles."""
        self._names: Names = ()
        self._track = np.zeros((0, len(UNKNOWN)))
        self._applied = AppliedCommand(np.zeros(0), np.zeros(0), np.zeros(0))
        self._eta = np.zeros((0, 3))  # as predicted
        self._assumed_eta = np.zeros((0, 3))  # with it fading where vehicles are not measured
        self._fading = FadingDownwash()
        self._others = Places((), np.zeros((0, 3)))  # of vehicles that are not commanded
        self._has_prediction = self._any_unmeasured = False
        self._t = math.inf
        self._elapsed = ElapsedTime()

    def set_back(self, by: float) -> None:
        """Shift stored times back by `by` [s]: the clock was."""
        self._t -= by
        self._fading.set_back(by)

    def wait(self) -> None:
        """Take a frame that is not newer than the last one: the vehicles fly on."""
        self._elapsed.wait()

    def advance(self, state: SwarmState | None, interference: Interference | None, t: float) -> None:
        """Advance all motions to the tick at t [s], and correct those of measured vehicles.

        Args:
            state: of the tick; None means that no vehicle was measured.
            interference: predicted downwash; None if none is predicted.
            t: time of the tick [s].
        """
        names = self._names
        measured = _measured(state, names)
        step, self._t = max(t - self._t, 0.0), t
        dt = self._elapsed.update(step, by_frame=state is not None)
        if step > GAP_S:
            self._track[:, UNSETTLED] = 2.0 * LAG_S + dt
        unmeasured = reckon(self._track, self._applied, self._assumed_eta, dt, measured)
        if state is not None:
            self._eta, self._has_prediction = predicted_eta(interference, names), interference is not None
        self._assumed_eta = self._eta
        if self._any_unmeasured or unmeasured:
            self._fade(state, measured.status)

    def reckoned(self, names: Names) -> dict[str, Reckoned]:
        """Return the dead-reckoned horizontal motions of those of the named vehicles that are known."""
        rows = [row for row in index_of(names, self._names) if row >= 0]
        if not rows:
            return {}
        pos, rest = self._track[rows, POS : POS + 2], resting_places(self._motions)[rows]
        return {self._names[row]: Reckoned(*one) for row, *one in zip(rows, pos, rest, strict=True)}

    def predicted(self, state: SwarmState) -> SwarmState:
        """Return the state with dead-reckoned positions and velocities where vehicles are not measured."""
        track = rows_by_name(self._track, self._names, state.names, UNKNOWN)
        rows = (state.status != TRACKED) & np.isfinite(track[:, POS])
        if not rows.any():
            return state
        pos, vel = state.pos.copy(), state.vel.copy()
        pos[rows], vel[rows] = track[rows, POS : POS + 3], track[rows, VEL : VEL + 3]
        return replace(state, pos=pos, vel=vel)

    def update(self, state: SwarmState | None, command: SwarmCommand) -> SwarmCommand:
        """Return the command of the tick with unmeasured vehicles braking instead of flying level.

        Args:
            state: of the tick, in which vehicles that were not commanded before begin; None if there is none.
            command: with fallbacks.
        """
        self._match(state, command.names)
        braking = levels_or_lands(command.status) & (self._track[:, SEEN] == 0.0)
        if braking.any():
            roll, pitch = braking_tilt(self._motions)
            level = braking_thrust(self._motions, command, self._hover_thrust)
            thrust = level / (np.cos(roll) * np.cos(pitch))
            command = replace(
                command,
                thrust=np.where(braking, thrust, command.thrust),
                roll=np.where(braking, roll, command.roll),
                pitch=np.where(braking, pitch, command.pitch),
            )
        self._record(command)
        return command

    def record_nominal(self, state: SwarmState, command: SwarmCommand) -> None:
        """Take the command of a tick in which every vehicle is measured."""
        self._match(state, command.names)
        self._record(command)

    @property
    def _motions(self) -> ReckonedMotions:
        return ReckonedMotions(self._track, self._assumed_eta)

    def _record(self, command: SwarmCommand) -> None:
        self._applied = AppliedCommand(command.thrust / self._hover_thrust, command.roll, command.pitch)
        self._t = command.t

    def _match(self, state: SwarmState | None, names: Names) -> None:
        """Match the tracks to `names`; new vehicles begin as the state shows them."""
        if names == self._names:
            return
        have, self._names = self._names, names
        self._track = rows_by_name(self._track, have, names, UNKNOWN)
        self._eta = rows_by_name(self._eta, have, names)
        self._assumed_eta = rows_by_name(self._assumed_eta, have, names)
        new = np.flatnonzero(index_of(names, have) < 0)
        hover = AppliedCommand(np.ones(new.size), np.zeros(new.size), np.zeros(new.size))
        begun, seen = self._track[new], _measured(state, tuple(names[row] for row in new))
        reckon(begun, hover, self._assumed_eta[new], 0.0, seen)
        self._track[new] = begun

    def _fade(self, state: SwarmState | None, status: Status) -> None:
        """Let the downwash of unmeasured vehicles fade; `status` is the TrackStatus, (n,)."""
        unmeasured = np.flatnonzero(self._track[:, SEEN] == 0.0)
        self._any_unmeasured = bool(unmeasured.size)
        self._assumed_eta = np.where(np.isfinite(self._eta), self._eta, 0.0)
        if state is not None:
            self._others = _measured_others(state, self._names)
        names, pos = self._names + self._others.names, self._track[:, POS : POS + 3]
        places = Places(names, np.vstack((pos, self._others.pos)))
        followed = (status[unmeasured] != LOST) & self._has_prediction
        left = self._fading.shares(unmeasured, followed, places, self._t)
        self._assumed_eta[unmeasured] *= left[:, None]
        self._assumed_eta[unmeasured, 2] += (1.0 - left) * self._track[unmeasured, TRIM + 2]


def levels_or_lands(status: Status) -> NDArray[np.bool_]:
    """Return which vehicles level or land in a fallback, without measurements, (n,)."""
    return np.asarray((status == LEVEL) | (status == LAND))


def _measured(state: SwarmState | None, names: Names) -> MeasuredState:
    """Return what a state shows of the vehicles."""
    if state is not None and state.names == names:
        return MeasuredState(state.pos, state.vel, state.quat, state.status)
    if state is None:
        n = len(names)
        return MeasuredState(np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 4)), np.full(n, LOST, np.uint8))
    pos, vel, quat = (rows_by_name(part, state.names, names) for part in (state.pos, state.vel, state.quat))
    status = rows_by_name(state.status, state.names, names, LOST)
    return MeasuredState(pos, vel, quat, status)


def _measured_others(state: SwarmState, names: Names) -> Places:
    """Return where a state shows vehicles that are not among `names`."""
    if state.names == names:
        return Places((), np.zeros((0, 3)))
    measured = (state.status == TRACKED) & np.isfinite(state.pos).all(axis=1)
    rows = np.flatnonzero(measured & (index_of(state.names, names) < 0))
    return Places(tuple(state.names[row] for row in rows), state.pos[rows])
