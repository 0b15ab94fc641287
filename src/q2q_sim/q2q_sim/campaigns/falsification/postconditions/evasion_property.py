"""What the guard states of vehicles below one that is lost, or little above it: they evade it.

| violation | statement that it breaks |
|---|---|
| evasion | a vehicle below one that is lost, or up to RISE above it, is accelerated, and not towards it |

With d the horizontal offset of the measured vehicle from the lost one in the tick before that is lost, and c
the change of its commanded acceleration to the next tick, less that of its setpoint:

    |c| >= LEAST_ACC                 where |d| < NEAR
    -c . d / |d| <= LEAST_ACC        where |d| > CLEAR and no third vehicle is near where it is sent

It is judged for the PID, whose command follows its setpoint at once, where nothing has deceived the dead
reckoning of either and the last frame of neither came late or again (hidden_motion): its state steps with the
next one. Nor is it where a vehicle was lost shortly before. The margin is the smallest distance from these
limits, at most 1; beyond NEAR it is the larger one of those from NEAR and from the limit.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from q2q_control.failsafe.evasion.descent_evasion import REACH, RISE
from q2q_control.failsafe.tracking_loss.dead_reckoned_braking import levels_or_lands
from q2q_model.flights.masks_over_time import runs_of_true
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, CommandStatus, Mask, TrackStatus
from q2q_sim.campaigns.falsification.postconditions.hidden_motion import (
    after_late_frame,
    misleading_measurement,
)
from q2q_sim.campaigns.falsification.postconditions.postcondition_outcome import PostconditionOutcome
from q2q_sim.campaigns.falsification.postconditions.run_ticks import RunTicks, over_ticks
from q2q_sim.campaigns.random_runs.random_run import Run
from q2q_sim.monitors.policies import Violation

CALM_TICKS = 300
"""Ticks in which no vehicle was lost before an evasion is judged: earlier shifts have ended."""
LEAST_ACC = 0.5
"""Smallest change of acceleration that is an evasion [m/s^2]: a quarter of PACE^2 (REACH - NEAR)."""
NEAR = 0.35
"""Horizontal distance below which a vehicle must evade [m]."""
CLEAR = 0.08
"""Horizontal distance above which its direction is known [m]: dead reckoning errs by less in 0.35 s."""
UNSURE = 0.2
"""Height by which one is further below another than it has to be [m]: markers and filters err by less."""
STILL = 1e-6
"""Distance that has no direction [m]."""
LEANING = 2.5
"""Acceleration from which a command may be at its limit of tilt [m/s^2]."""


class _Encounter(NamedTuple):
    """Tick before vehicle j is lost, and a measured vehicle i."""

    tick: int
    i: int
    j: int


class _Reaction(NamedTuple):
    """What a vehicle does in an encounter."""

    distance: float
    """Horizontal, from the lost vehicle [m]."""
    change: float
    """Size of the change of its acceleration [m/s^2]."""
    towards: float
    """Part of it that leads towards the lost vehicle; -inf where this is not known [m/s^2]."""

    @property
    def bad(self) -> bool:
        """Return whether it does not evade, or the wrong way."""
        return (self.distance < NEAR and self.change < LEAST_ACC) or self.towards > LEAST_ACC

    @property
    def margin(self) -> float:
        """Return how far it is from that, at most 1 [-]."""
        evades = max(self.distance / NEAR - 1.0, self.change / LEAST_ACC - 1.0)
        return min(evades, 1.0 - self.towards / LEAST_ACC, 1.0)


def evasion(run: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the vehicles that do not evade one that is lost (PID only)."""
    if run.options.controller != "pid":
        return PostconditionOutcome()
    found, margin = [], np.inf
    faults, acc = run.scenario.faults, ticks.commanded_acc()
    known = ~(misleading_measurement(ticks, faults) | after_late_frame(ticks, faults))
    for one in _encounters(ticks):
        if not known[one.tick, [one.i, one.j]].all() or np.abs(acc[one.tick, one.i]).max() > LEANING:
            continue
        reaction = _reaction(ticks, one, acc)
        margin = min(margin, reaction.margin)
        if reaction.bad:
            away = reaction.change if reaction.change < LEAST_ACC else -reaction.towards
            found.append(Violation("evasion", ticks.names[one.i], float(ticks.t[one.tick]), away, LEAST_ACC))
    return PostconditionOutcome(tuple(found), margin)


def _reaction(ticks: RunTicks, one: _Encounter, acc: Array) -> _Reaction:
    """Return what the measured vehicle does; `acc` is the commanded acceleration [m/s^2], (T, n, 2)."""
    offset = (ticks.states[one.tick].pos[one.i] - ticks.truth[one.tick].pos[one.j])[:2]
    distance = float(np.linalg.norm(offset))
    away = offset / max(distance, STILL)
    change = acc[one.tick + 1, one.i] - acc[one.tick, one.i] - _asked(ticks, one)
    sided = distance > CLEAR and _alone(ticks, one, away)
    return _Reaction(distance, float(np.linalg.norm(change)), float(-change @ away) if sided else -np.inf)


def _asked(ticks: RunTicks, one: _Encounter) -> Array:
    """Return the change of the setpoint's own acceleration, which is none of the evasion, (2,)."""
    before, after = ticks.setpoints[one.tick], ticks.setpoints[one.tick + 1]
    return np.asarray(after.acc[one.i, :2] - before.acc[one.i, :2])


def _encounters(ticks: RunTicks) -> Iterator[_Encounter]:
    """Yield the vehicles steadily measured when another is lost."""
    lost = over_ticks(ticks.states, "status") == TrackStatus.LOST
    unmeasured = lost | levels_or_lands(ticks.command_status)
    for j in range(len(ticks.names)):
        for begin, end in runs_of_true(lost[:, j]):
            before = begin - 1
            if unmeasured[max(begin - CALM_TICKS, 0) : begin].any() or not 1 <= before < end - 2:
                continue
            low = ticks.truth[before].pos[:, 2] < ticks.truth[before].pos[j, 2] + RISE - UNSURE
            for i in np.flatnonzero(_steady(ticks, before) & low):
                yield _Encounter(before, int(i), j)


def _steady(ticks: RunTicks, tick: int) -> Mask:
    """Return which vehicles are measured at a tick and its neighbours, with stamps in order, (n,)."""
    around = range(tick - 1, tick + 2)
    in_order = bool((np.abs(np.diff(ticks.stamp[tick - 1 : tick + 2]) - TICK_S) < 0.5 * TICK_S).all())
    tracked = [ticks.states[k].status == TrackStatus.TRACKED for k in around]
    computed = [ticks.commands[k].status <= CommandStatus.SATURATED for k in around]
    return np.asarray(np.all(tracked, axis=0) & np.all(computed, axis=0) & in_order)


def _alone(ticks: RunTicks, one: _Encounter, away: Array) -> bool:
    """Return whether no third vehicle is near where an evasion straight away leads."""
    pos = ticks.truth[one.tick].pos[:, :2]
    others = np.delete(pos, (one.i, one.j), axis=0)
    goal = pos[one.j] + REACH * away
    return bool((np.linalg.norm(others - goal, axis=1) > 2.0 * REACH).all())
