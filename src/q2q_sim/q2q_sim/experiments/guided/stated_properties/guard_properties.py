"""What the guard states of its own commands (q2q_control.failsafe).

| property | statement |
|---|---|
| told | a command on a state of a vehicle older than `degraded_s` is not OK |
| repeat | a command repeated at another tick is not OK, except where a newer state is the same |
| hold | a vehicle has status HOLD for at most HOLD_S, once more for every clock that was set back |
| brake | a vehicle flown level without measurements is decelerated, as far as its speed is known |
| evasion | a measured vehicle below one that is lost is accelerated, and not towards it |

The last two are judged where the dead-reckoned velocity and position are known well enough to decide:
commands in the lag, wind and a push aside change the velocity by less than half of FAST.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from q2q_control.failsafe.blind_flight.braking_law import BRAKING_MAX, BRAKING_S
from q2q_control.failsafe.blind_flight.dead_reckoned_braking import is_blind
from q2q_control.failsafe.blind_flight.dead_reckoning import LAG_S
from q2q_control.failsafe.evasion.descent_evasion import BENEATH, REACH
from q2q_control.failsafe.ladder import FallbackParams
from q2q_control.pid.pid import PidParams
from q2q_model.signals.values import Array, CommandStatus, TrackStatus
from q2q_sim.experiments.campaign.random_run import Run
from q2q_sim.experiments.guided.stated_properties.run_ticks import RunTicks, over_ticks
from q2q_sim.experiments.guided.stated_properties.stated_outcome import StatedOutcome, struck
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.assembly import TICK_S
from q2q_sim.monitors.policies import Violation
from q2q_sim.monitors.policies.blindness import runs

UNTOLD_S = FallbackParams().degraded_s + TICK_S
"""Largest age of a state on which a command may be OK [s]."""
HOLD_S = PidParams().hold_time + 3.0 * TICK_S
"""Longest hold [s]: hold_time, and the ticks in which it begins and ends."""
FAST = 0.6
"""Speed from which braking is judged [m/s]."""
SHARE = 0.25
"""Least share of the braking that the true speed asks for [-]."""
DECEIVING = ("jump", "swap", "clock_jump", "radio_loss")
"""Faults after which the dead-reckoned velocity may be wrong."""
LEARNT_S = 1.0
"""Time in which most of a balance is learned [s]: two of the observer's time constants, horizontally."""
CALM_TICKS = 300
"""Ticks in which a vehicle was not lost before its evasion is judged: earlier shifts have ended."""
LEAST_ACC = 0.5
"""Smallest change of acceleration that is an evasion [m/s^2]: a quarter of PACE^2 (REACH - NEAR)."""
NEAR, CLEAR = 0.35, 0.15
"""Horizontal distances: below NEAR a vehicle must evade, above CLEAR the direction is known [m]."""
STILL = 1e-6
"""Distance that has no direction [m]."""
LEANING = 2.5
"""Acceleration from which a command may be at its limit of tilt [m/s^2]."""

Mask = NDArray[np.bool_]


def told(_: Run, ticks: RunTicks) -> StatedOutcome:
    """Return the vehicles whose command is OK though their state says that it is old."""
    age = over_ticks(ticks.states, "age")
    untold = np.where(ticks.command_status <= CommandStatus.SATURATED, age, 0.0)
    k, row = np.unravel_index(int(untold.argmax()), untold.shape)
    oldest = float(untold[k, row])
    found = (Violation("told", ticks.names[row], float(ticks.t[k]), oldest, UNTOLD_S),)
    return StatedOutcome(found if oldest > UNTOLD_S else (), (UNTOLD_S - oldest) / UNTOLD_S)


def repeat(_: Run, ticks: RunTicks) -> StatedOutcome:
    """Return the repeated commands that are reported as computed ones."""
    values = np.stack([over_ticks(ticks.commands, one) for one in ("thrust", "roll", "pitch", "yaw_rate")])
    pos = over_ticks(ticks.states, "pos")
    alike = (pos[1:] == pos[:-1]).all(axis=2) & ticks.newer[1:, None]
    same = (values[:, 1:] == values[:, :-1]).all(axis=0) & (ticks.stamp[1:] != ticks.stamp[:-1])[:, None]
    same &= ~alike
    computed = ticks.command_status == CommandStatus.OK
    bad = same & computed[1:] & computed[:-1]
    return StatedOutcome(
        tuple(
            Violation("repeat", name, float(ticks.t[1 + bad[:, row].argmax()]), float(bad[:, row].sum()), 0.0)
            for row, name in enumerate(ticks.names)
            if bad[:, row].any()
        )
    )


def hold(run: Run, ticks: RunTicks) -> StatedOutcome:
    """Return the vehicles held for too long, by the stamps of their commands."""
    set_back = sum(fault.kind == "clock_jump" for fault in run.scenario.faults)
    limit = HOLD_S * (1 + set_back)
    found, longest = [], 0.0
    for row, name in enumerate(ticks.names):
        for begin, end in runs(ticks.command_status[:, row] == CommandStatus.HOLD):
            held = len(np.unique(ticks.stamp[begin:end])) * TICK_S
            longest = max(longest, held)
            if held > limit:
                found.append(Violation("hold", name, float(ticks.t[begin]), held, limit))
    return StatedOutcome(tuple(found), (limit - longest) / limit)


def brake(run: Run, ticks: RunTicks) -> StatedOutcome:
    """Return the vehicles that fly level without braking."""
    late = round(LAG_S / TICK_S)
    true_vel = _true_vel(ticks)
    vel = true_vel[late:]  # once the commands have taken effect
    speed = np.linalg.norm(vel, axis=2)
    acc = ticks.commanded_acc()[: len(vel)]
    level = is_blind(ticks.command_status)
    judged = level[: len(vel)] & level[late:] & (speed > FAST)
    last = _last_measured(ticks)[: len(vel)]
    before = np.take_along_axis(true_vel, last[..., None], axis=0)  # a push since then is unknown
    judged &= np.einsum("tnk,tnk->tn", before, vel) > FAST * speed
    judged &= ~_outdated(ticks, run.scenario.faults)[last]
    judged &= ~_unbalanced(ticks, run.scenario.faults, last)
    judged &= ~np.array(struck(ticks.names, run.scenario.faults, DECEIVING))
    due = np.minimum(speed / BRAKING_S, BRAKING_MAX) * np.maximum(speed, FAST)
    share = np.full(judged.shape, np.inf)
    share[judged] = -np.einsum("mk,mk->m", acc[judged], vel[judged]) / due[judged]
    k, row = np.unravel_index(int(share.argmin()), share.shape)
    least = float(share[k, row])
    bad = (Violation("brake", ticks.names[row], float(ticks.t[k]), least, SHARE),) if least < SHARE else ()
    return StatedOutcome(bad, (least - SHARE) / SHARE)


def _true_vel(ticks: RunTicks) -> Array:
    """Return the true horizontal velocities [m/s], (T, n, 2)."""
    return over_ticks(ticks.truth, "vel")[..., :2]


def _last_measured(ticks: RunTicks) -> NDArray[np.intp]:
    """Return the tick in which each vehicle was last measured, (T, n)."""
    measured = over_ticks(ticks.states, "age") <= 0.0
    return np.maximum.accumulate(np.where(measured, np.arange(len(measured))[:, None], 0), axis=0)


def _outdated(ticks: RunTicks, faults: tuple[Fault, ...]) -> Mask:
    """Return the ticks whose frames come late, or again, with the velocities of then, (T,)."""
    outdated = np.zeros(len(ticks.t), dtype=np.bool_)
    for fault in faults:
        if fault.kind in ("late", "stale"):
            end = fault.start + fault.duration + fault.size
            outdated |= (ticks.t >= fault.start - TICK_S) & (ticks.t <= end)
    return outdated


def _unbalanced(ticks: RunTicks, faults: tuple[Fault, ...], last: NDArray[np.intp]) -> Mask:
    """Return where a rotor weakened or recovered after, or shortly before, the `last` measurement, (T, n)."""
    t, seen = ticks.t[: len(last), None], ticks.t[last]
    unbalanced = np.zeros(last.shape, dtype=np.bool_)
    for fault in faults:
        weak = np.array(struck(ticks.names, (fault,), ("weak_rotor",)))
        for change in (fault.start, fault.start + fault.duration):
            unbalanced |= weak & (t >= change) & (seen < change + LEARNT_S)
    return unbalanced


class _Encounter(NamedTuple):
    """Tick before vehicle j is lost, and vehicle i below it."""

    tick: int
    i: int
    j: int


def evasion(run: Run, ticks: RunTicks) -> StatedOutcome:
    """Return the vehicles that do not evade one that is lost above them (PID only)."""
    if run.options.controller != "pid":
        return StatedOutcome()
    acc, found = ticks.commanded_acc(), []
    known = ~np.array(struck(ticks.names, run.scenario.faults, DECEIVING))
    for one in _encounters(ticks):
        away = (ticks.states[one.tick].pos[one.i] - ticks.truth[one.tick].pos[one.j])[:2]
        distance = float(np.linalg.norm(away))
        change = acc[one.tick + 1, one.i] - acc[one.tick, one.i] - _asked(ticks, one)
        if not (known[one.i] and known[one.j]) or np.abs(acc[one.tick, one.i]).max() > LEANING:
            continue
        towards = float(-change @ away) / max(distance, STILL)
        still = distance < NEAR and float(np.linalg.norm(change)) < LEAST_ACC
        sided = CLEAR < distance < REACH - CLEAR and _alone(ticks, one, away / max(distance, STILL))
        if still or (sided and towards > LEAST_ACC):
            who, t = ticks.names[one.i], float(ticks.t[one.tick])
            found.append(Violation("evasion", who, t, -towards, LEAST_ACC))
    return StatedOutcome(tuple(found))


def _asked(ticks: RunTicks, one: _Encounter) -> Array:
    """Return the change of the setpoint's own acceleration, which is none of the evasion, (2,)."""
    before, after = ticks.setpoints[one.tick], ticks.setpoints[one.tick + 1]
    return np.asarray(after.acc[one.i, :2] - before.acc[one.i, :2])


def _encounters(ticks: RunTicks) -> Iterator[_Encounter]:
    """Yield the vehicles steadily measured below one that is lost."""
    lost = over_ticks(ticks.states, "status") == TrackStatus.LOST
    blind = lost | is_blind(ticks.command_status)
    for j in range(len(ticks.names)):
        for begin, end in runs(lost[:, j]):
            before = begin - 1
            if blind[max(begin - CALM_TICKS, 0) : begin].any() or not 1 <= before < end - 2:
                continue
            pos = ticks.truth[before].pos
            for i in np.flatnonzero(_steady(ticks, before) & (pos[:, 2] < pos[j, 2] - 2.0 * BENEATH)):
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
