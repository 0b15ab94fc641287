"""Guard a controller: fly by it while what it knows is young, and down the ladder of safety as it grows old.

The same object stands before the PID and the MPC, in closed_loop and in the nodes; the ladder itself is
q2q_control.failsafe.ladder. The age of what is known of vehicle i at the tick t is

    a_i = t - b_i + l        b_i = t - (t - t_state) - age_i   where the controller could use the state,
                             b_i as it was                     where it answered HOLD or LEVEL

so it grows by stamps, whether samples, frames or whole messages stay away. A vehicle that was never seen
counts from the guard's first tick. Seen again before it is cut, a vehicle flies on; cut, it stays cut.

| symbol | name | meaning [unit] |
|---|---|---|
| a | ages | age of what is known [s], (n,) |
| b | _basis | time of the newest believed measurement [s], (n,) |
| age | state.age | since the last accepted measurement, as the filter says [s], (n,) |
| l | lateness | how much later than usual the tick came, live [s] |

Who is level because nobody sees it brakes from the speed it must have
(q2q_control.failsafe.dead_reckoned_braking); who is seen and flies beneath it makes way
(q2q_control.failsafe.descent_evasion).

A tick older than the last answered one gets the last answer again, as HOLD, under its own stamp. Old ticks
that rise for long enough (q2q_model.estimation.clock_resets, as in the mocap filter) are those of a clock
that was set back: the controller begins anew, ages go on. Older by more than RESTART it is another flight:
everything is forgotten but an emergency.
"""

from collections.abc import Callable
from dataclasses import replace
from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from q2q_control.failsafe.dead_reckoned_braking import DeadReckonedBraking
from q2q_control.failsafe.descent_evasion import DescentEvasion
from q2q_control.failsafe.ladder import FallbackParams, descended, fallback_command
from q2q_control.inputs.controller import Controller
from q2q_model.compiled import compiled
from q2q_model.estimation.clock_resets import ClockResetDetector
from q2q_model.signals.values import (
    Array,
    CommandStatus,
    Interference,
    Names,
    Status,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    index_of,
)

RESTART = 1.0
"""A clock set back by more is a flight that begins again [s]: the mocap filter's clock_jump_s."""
_SOUND = int(CommandStatus.SATURATED)
"""The statuses up to here are computed from a usable state."""


def on_time(_: float) -> float:
    """Return 0: the tick itself is the clock, as in lockstep."""
    return 0.0


class Guard:
    """State machine of command safety: since when each vehicle is in which phase, and who is cut."""

    def __init__(
        self,
        controller: Controller,
        params: FallbackParams,
        hover_thrust: float,
        lateness: Callable[[float], float] = on_time,
    ) -> None:
        """Guard a controller.

        Args:
            controller: computes the commands.
            params: ages of the phases.
            hover_thrust: thrust that carries one vehicle [N].
            lateness: says how much later than usual the tick of a stamp [s] came [s].
        """
        self._controller = controller
        self._params = params
        self._hover_thrust = hover_thrust
        self._lateness = lateness
        self._emergency = False
        self._braking = DeadReckonedBraking()
        self._way = DescentEvasion()
        self._last: SwarmCommand | None = None
        self._calm: SwarmState | None = None  # of the last tick, where all was known of everybody
        self._old = ClockResetDetector()
        self._names: Names = ()
        self._basis = np.zeros(0)
        self._down: NDArray[np.bool_] = np.zeros(0, dtype=np.bool_)

    @property
    def newest(self) -> float:
        """Return the stamp of the last tick that was answered as a new one [s]; -inf for none."""
        return -inf if self._last is None else self._last.t

    def reset(self) -> None:
        """Forget everything, the controller's memory too; an emergency stays."""
        self._controller.reset()
        self._forget()

    def cut(self) -> None:
        """Cut all motors from now on, for good: an emergency."""
        self._emergency = True

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command; `interference` None means ignoring the downwash."""
        last = self._last
        if last is not None and setpoint.t < last.t:
            if last.t - setpoint.t <= RESTART and not self._old.rise(setpoint.t):
                return _again(last, setpoint.t)
            last = self._set_back(last, setpoint.t)
        self._old.reset()
        if last is not None and (self._calm is None or self._way.active):
            setpoint = self._way.update(setpoint, state, last, self._braking.places)
        command = self._controller.update(state, setpoint, interference)
        known = command.t - state.t + self._lateness(command.t)
        if self._is_calm(command, state, known):
            self._last, self._calm = command, state
            return command
        self._note_sight()
        laddered = self._laddered(command, _ages(state, command.names) + max(known, 0.0))
        self._last = self._braking.update(state, laddered)
        return self._last

    def without_tick(self, age: float) -> SwarmCommand | None:
        """Return what is due `age` [s] after the last answered tick; None where it is merely late."""
        last = self._last
        if last is None or (age < self._params.hold_s and not self._emergency):
            return None
        ages = last.t - self._basis + age
        self._down = self._down | ~(ages < self._params.cut_s) | self._emergency
        held = fallback_command(last, age, self._params, self._hover_thrust)
        self._note_sight()
        return self._braking.update(None, descended(held, ages, self._down, self._params, self._hover_thrust))

    def _note_sight(self) -> None:
        """Note where everybody was at the last calm tick, now that calm is over."""
        if self._calm is not None and self._last is not None:
            self._braking.sighted(self._calm, self._last)
        self._calm = None

    def _set_back(self, last: SwarmCommand, t: float) -> SwarmCommand | None:
        """Set back what is counted from stamps, or begin anew; return the last command by the new clock."""
        back = last.t - t
        if back > RESTART:
            self.reset()
            return None
        self._controller.reset()
        self._basis = self._basis - back
        self._last = replace(last, t=t)
        return self._last

    def _forget(self) -> None:
        self._last, self._names = None, ()
        self._calm = None
        self._braking.reset()
        self._way.reset()
        self._basis = np.zeros(0)
        self._down = np.zeros(0, dtype=np.bool_)

    def _is_calm(self, command: SwarmCommand, state: SwarmState, known: float) -> bool:
        """Return whether all is known of everybody, and note since when: nearly every tick."""
        if self._emergency or command.names != self._names or state.names != self._names:
            return False
        values = np.concatenate((command.thrust, command.roll, command.pitch, command.yaw_rate))
        ages = state.age + known
        if not all_calm((ages, known, self._params.degraded_s), values, command.status, self._down):
            return False
        self._basis = command.t - state.age - max(known, 0.0)
        return True

    def _laddered(self, command: SwarmCommand, heard: Array) -> SwarmCommand:
        """Return the command as it may be sent; `heard` is the state's age of every vehicle [s], (n,)."""
        self._follow(command)
        command = self._without_nonsense(command)
        sound = command.status <= _SOUND
        self._basis = np.where(sound, np.fmax(self._basis, command.t - heard), self._basis)
        ages = command.t - self._basis
        self._down = self._down | ~(ages < self._params.cut_s) | self._emergency
        predicted = sound & ~(ages < self._params.degraded_s)
        status = np.where(predicted, CommandStatus.DEGRADED, command.status).astype(np.uint8)
        told = replace(command, status=status)
        return descended(told, ages, self._down, self._params, self._hover_thrust)

    def _follow(self, command: SwarmCommand) -> None:
        """Keep what is known of vehicles by name; a new one is known since now."""
        if command.names == self._names:
            return
        rows = index_of(command.names, self._names)
        self._basis = np.append(self._basis, command.t)[rows]
        self._down = np.append(self._down, False)[rows]
        self._names = command.names

    def _without_nonsense(self, command: SwarmCommand) -> SwarmCommand:
        """Return the command with level hover, and so marked, where a controller did not give numbers."""
        values = np.stack([command.thrust, command.roll, command.pitch, command.yaw_rate])  # (4, n)
        bad = ~np.isfinite(values).all(axis=0)
        if not bad.any():
            return command
        level = np.array([[self._hover_thrust], [0.0], [0.0], [0.0]])
        thrust, roll, pitch, yaw_rate = np.where(bad, level, values)
        status = np.where(bad, CommandStatus.LEVEL, command.status).astype(np.uint8)
        return SwarmCommand(command.t, command.names, thrust, roll, pitch, yaw_rate, status)


def _all_calm(
    known: tuple[Array, float, float], values: Array, status: Status, down: NDArray[np.bool_]
) -> bool:
    ages, least, most = known
    for i in range(ages.size):
        if not (least <= ages[i] < most) or status[i] > _SOUND or down[i]:
            return False
    for value in values:  # noqa: SIM110  numba knows no all()
        if not isfinite(value):
            return False
    return True


all_calm = compiled(_all_calm)
"""Return whether all is known of everybody: ((ages of what is known [s] (n,), their least and their bound),
the commands' numbers, status, whose motors are off (n,))."""


def _again(last: SwarmCommand, t: float) -> SwarmCommand:
    """Return a command that is given again at a tick t [s], and says so."""
    held = np.where(last.status <= _SOUND, CommandStatus.HOLD, last.status).astype(np.uint8)
    return replace(last, t=t, status=held)


def _ages(state: SwarmState, names: Names) -> Array:
    """Return the age of each vehicle's measurement [s], infinite where there is none, (n,)."""
    ages = np.append(np.where(state.age >= 0.0, state.age, np.inf), np.inf)
    return np.asarray(ages[index_of(names, state.names)])
