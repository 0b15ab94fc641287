"""Guard a controller: pass its commands on while measurements are fresh, fall back as they grow old.

The same guard wraps the PID and the MPC, in closed_loop and in the nodes. The fallback phases are those of
q2q_control.failsafe.fallback_phases, by the age of vehicle i's measurement at tick t:

    a_i = t - b_i     b_i = t - max(t - t_state + max(l, 0), 0) - age_i   if the controller used the state,
                      b_i unchanged                                       if it answered HOLD or LEVEL

The age grows by stamps, whether samples, frames or whole messages are missing; live, b moves with a clock
that is set ahead. A vehicle that was never measured counts from its first tick. One measured again before it
is cut flies on; a cut is final, also for one that is not commanded meanwhile.

| symbol | name | meaning [unit] |
|---|---|---|
| a | ages | age of the newest measurement [s], (n,) |
| b | _measured_at | stamp of the newest accepted measurement [s], (n,) |
| age | state.age | time since the last accepted measurement, from the filter [s], (n,) |
| l | lateness | delay of the tick beyond the usual one, live only; below -AHEAD_S a clock set ahead [s] |

A vehicle without measurements is flown on its dead-reckoned state while the controller still flies it, and
brakes once it flies level (q2q_control.failsafe.tracking_loss). Measured vehicles below one that the state
reports as LOST move aside, also if another controller flies it: that takes the same fallback. Measured again,
a vehicle returns to the height of its setpoint before it follows that (q2q_control.failsafe.evasion).

A tick that is not newer than the last one, or far ahead for less than CONFIRM_S:

| its stamp | what it gets |
|---|---|
| the same | the same command |
| older, or newer by more than AHEAD_S | the last command, as HOLD, under its own stamp |
| older, in a long run of rising ones | the clock was set back: the controller is reset, ages continue |
| the same, back by more than SET_BACK_S | a new flight: everything is reset but an emergency |
| not newer for level_after_s | that of a missing tick, LEVEL at most: in a halted simulator nobody lands |

The runs are those of q2q_model.signals.clock_resets, as in the mocap filter; level_after_s is counted by
stalled_stamps.
Live, a timer asks for the commands of missing ticks: the same or an older tick gets the latest of these.
"""

from collections.abc import Callable
from dataclasses import replace
from math import inf, nextafter

import numpy as np
from numpy.typing import NDArray

from q2q_control.controller import Controller
from q2q_control.failsafe.evasion.climb_back import InFallback
from q2q_control.failsafe.evasion.descent_evasion import DescentEvasion
from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.failsafe.fallback_phases import (
    apply_land_and_cut,
    fallback_command,
    level_where_not_finite,
    repeated_command,
)
from q2q_control.failsafe.nominal_tick import SOUND, StateAndCommand, TickTimes, note_nominal
from q2q_control.failsafe.stalled_stamps import StalledStamps
from q2q_control.failsafe.tracking_loss.dead_reckoned_braking import DeadReckonedBraking, levels_or_lands
from q2q_model.signals.clock_resets import AHEAD_S, SET_BACK_S, ClockResetDetector
from q2q_model.signals.stamps import SAME_INSTANT
from q2q_model.signals.values import (
    LOST,
    Array,
    CommandStatus,
    Interference,
    Names,
    Status,
    SwarmCommand,
    SwarmSetpoint,
    SwarmState,
    rows_by_name,
)


def on_time(_: float) -> float:
    """Return 0: in lockstep no tick is late."""
    return 0.0


class Guard:
    """Guarded controller: age of every vehicle's measurement, and which motors are cut."""

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
            params: ages at which the phases change.
            hover_thrust: thrust of one vehicle at hover [N].
            lateness: returns how much later than usual the tick of a stamp [s] arrived [s].
        """
        self._controller = controller
        self._params = params
        self._hover_thrust = hover_thrust
        self._lateness = lateness
        self._emergency = False
        self._braking = DeadReckonedBraking(hover_thrust)
        self._evasion = DescentEvasion()
        self._last: SwarmCommand | None = None
        self._missing: SwarmCommand | None = None  # newest one since then, of a missing tick
        self._timed = False  # a timer asks for those: live
        self._was_nominal = False  # in the last tick everybody was measured, commanded and on
        self._clock_reset = ClockResetDetector()
        self._stalled = StalledStamps()
        self._names: Names = ()
        self._measured_at = np.zeros(0)
        self._is_cut: NDArray[np.bool_] = np.zeros(0, dtype=np.bool_)
        self._cut_names: set[str] = set()  # cut vehicles that were commanded before, too
        self.flights = 1
        """Number of flights begun, the first included: each reset begins another."""

    @property
    def newest(self) -> float:
        """Return the stamp of the last tick that was not a repeated or old one [s]; -inf before the first."""
        return -inf if self._last is None else self._last.t

    def reset(self) -> None:
        """Reset the guard and its controller; an emergency remains."""
        self.flights += 1
        self._controller.reset()
        self._forget()

    def begin_flight(self) -> None:
        """Reset the controller, whose commands are flown from now on; ages and cut motors remain."""
        self._controller.reset()

    @property
    def emergency(self) -> bool:
        """Return whether an emergency has cut all motors."""
        return self._emergency

    def cut_all(self) -> SwarmCommand | None:
        """Cut all motors permanently: an emergency; return the command to send, None before any tick."""
        self._emergency = True
        if self._last is not None:
            self._last = self._fallen_back(self._last, 0.0)  # which a late tick repeats
        return self._last

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the command of the tick; `interference` None ignores downwash."""
        last = self._last
        if last is not None and (setpoint.t <= last.t or self._clock_reset.reject_ahead(setpoint.t, last.t)):
            repeated = self._repeated(last, setpoint.t)
            if repeated is not None:
                return repeated
        self._clock_reset.reset()
        setpoint = self._evaded(state, setpoint)
        self._missing = None
        self._braking.advance(state, interference, setpoint.t)
        flown = self._braking.predicted(state) if np.count_nonzero(state.status) else state  # TRACKED is 0
        command = self._controller.update(flown, setpoint, interference)
        self._last = self._guarded(state, command)
        return self._last

    def without_tick(self, age: float) -> SwarmCommand | None:
        """Return the command due `age` [s] after the last tick; None before hold_after_s."""
        last, self._timed = self._last, True
        return None if last is None or age < self._params.hold_after_s else self._fallen_back(last, age)

    def _evaded(self, state: SwarmState, setpoint: SwarmSetpoint) -> SwarmSetpoint:
        """Return the setpoint after descent evasion; itself while nobody falls back nor evades."""
        last = self._last
        if last is None or (self._was_nominal and not self._evasion.active):
            return setpoint
        cut = tuple(self._names[row] for row in np.flatnonzero(self._is_cut))
        absent = InFallback(self._lost(state, self._missing or last), cut)
        return self._evasion.update(setpoint, state, absent, self._braking.reckoned(absent.lost))

    def _guarded(self, state: SwarmState, command: SwarmCommand) -> SwarmCommand:
        """Return the controller's command in a nominal tick, else what the fallback phases make of it."""
        late = self._lateness(command.t)
        if late < -AHEAD_S:
            self._measured_at -= late
        state_delay = command.t - state.t + max(late, 0.0)
        age = state.age if state.names == command.names else _ages(state, command.names)
        self._was_nominal = self._note_if_nominal(command, state, age, state_delay)
        if self._was_nominal:
            self._braking.record_nominal(state, command)
            return command
        fallback = self._with_fallback(command, np.where(age >= 0.0, age, np.inf) + max(state_delay, 0.0))
        return self._braking.update(state, fallback)

    def _fallen_back(self, last: SwarmCommand, age: float) -> SwarmCommand:
        """Return the command by the phases alone, `age` [s] after the last one."""
        ages = last.t - self._measured_at + age
        self._is_cut = self._is_cut | ~(ages < self._params.cut_after_s) | self._emergency
        held = fallback_command(last, age, self._params, self._hover_thrust)
        self._was_nominal = False
        descending = apply_land_and_cut(held, ages, self._is_cut, self._params, self._hover_thrust)
        self._braking.advance(None, None, held.t)
        self._missing = self._braking.update(None, descending)
        return self._missing

    def _repeated(self, last: SwarmCommand, t: float) -> SwarmCommand | None:
        """Return the command of a tick t [s] that is not newer, or far ahead; None to compute it."""
        stalled_s = self._stalled.update(last.t)
        counted = self._timed and self._missing is not None  # by the timer
        if not counted:
            self._braking.wait()
        if t < last.t and self._clock_reset.confirm_reset(t):
            self._set_back(last, t)
            return None
        if stalled_s > self._params.level_after_s + SAME_INSTANT and not self._timed:
            braked = self._fallen_back(last, min(stalled_s, nextafter(self._params.land_after_s, 0.0)))
            return replace(braked, t=t)
        return repeated_command(self._missing or last, t) if t != last.t or counted else None

    def _set_back(self, last: SwarmCommand, t: float) -> None:
        """Shift stored stamps to the new clock, whose first is t [s], or reset."""
        by = last.t - self._clock_reset.first
        if by > SET_BACK_S:
            self.reset()
            return
        self._controller.reset()
        self._braking.set_back(by)
        self._measured_at = self._measured_at - by
        self._last = replace(last, t=t)

    def _forget(self) -> None:
        self._last, self._missing, self._names, self._was_nominal = None, None, (), False
        self._stalled = StalledStamps()
        self._braking.reset()
        self._evasion.reset()
        self._measured_at = np.zeros(0)
        self._is_cut = np.zeros(0, dtype=np.bool_)
        self._cut_names = set()

    def _note_if_nominal(
        self, command: SwarmCommand, state: SwarmState, age: Array, state_delay: float
    ) -> bool:
        """Store when each vehicle was measured, and return True, if all are measured, commanded and on.

        Nearly every tick is. The state is `state_delay` [s] old, its ages are `age` [s], (n,).
        """
        if self._emergency or command.names != self._names:
            return False
        if state.names != self._names and (state.status == LOST).any():
            return False
        values = np.concatenate((command.thrust, command.roll, command.pitch, command.yaw_rate))
        times = TickTimes(command.t, state_delay, self._params.degraded_after_s)
        track = state.status if state.names == command.names else _track(state, command.names)
        given = StateAndCommand(age.copy(), track.copy(), values, command.status)
        return note_nominal(times, given, (self._is_cut, self._measured_at))

    def _lost(self, state: SwarmState, last: SwarmCommand) -> Names:
        """Return the vehicles that are lost by the state, or level or land by the last command."""
        level = {last.names[row] for row in np.flatnonzero(levels_or_lands(last.status))}
        lost = np.flatnonzero((state.status == LOST) & (state.age < self._params.cut_after_s))
        return tuple(sorted(level.union(state.names[row] for row in lost)))

    def _with_fallback(self, command: SwarmCommand, state_age: Array) -> SwarmCommand:
        """Return the command after the fallback phases; `state_age` is the age in the state [s], (n,)."""
        self._match_names(command)
        command = level_where_not_finite(command, self._hover_thrust)
        sound = command.status <= SOUND
        self._measured_at = np.where(
            sound, np.fmax(self._measured_at, command.t - state_age), self._measured_at
        )
        ages = command.t - self._measured_at
        self._is_cut = self._is_cut | ~(ages < self._params.cut_after_s) | self._emergency
        predicted = sound & ~(ages < self._params.degraded_after_s)
        status = np.where(predicted, CommandStatus.DEGRADED, command.status).astype(np.uint8)
        flagged = replace(command, status=status)
        return apply_land_and_cut(flagged, ages, self._is_cut, self._params, self._hover_thrust)

    def _match_names(self, command: SwarmCommand) -> None:
        """Match stored rows to the command's names; a new vehicle counts as measured now."""
        if command.names == self._names:
            return
        self._cut_names.update(name for name, is_cut in zip(self._names, self._is_cut, strict=True) if is_cut)
        self._measured_at = rows_by_name(self._measured_at, self._names, command.names, command.t)
        self._is_cut = np.array([name in self._cut_names for name in command.names], dtype=np.bool_)
        self._names = command.names


def _ages(state: SwarmState, names: Names) -> Array:
    """Return the age of each vehicle's measurement [s], (n,); infinite if there is none."""
    return rows_by_name(state.age, state.names, names, np.inf)


def _track(state: SwarmState, names: Names) -> Status:
    """Return the TrackStatus of each vehicle, (n,); LOST if there is none."""
    return rows_by_name(state.status, state.names, names, LOST)
