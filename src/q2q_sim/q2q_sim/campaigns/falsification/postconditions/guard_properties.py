"""What the guard states of its own commands (q2q_control.failsafe).

| violation | statement that it breaks |
|---|---|
| stale_reported_ok | a command on a state of a vehicle older than `degraded_after_s` is not OK |
| repeat_reported_ok | a command repeated at another tick is not OK, except where a newer state is the same |
| hold_too_long | who is not lost is held or level for HOLD_S at most, once more for every clock set back |
"""

import numpy as np

from q2q_control.failsafe.fallback_params import FallbackParams
from q2q_control.pid.pid_params import PidParams
from q2q_model.flights.masks_over_time import runs_of_true
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import CommandStatus, TrackStatus
from q2q_sim.campaigns.falsification.postconditions.postcondition_outcome import PostconditionOutcome
from q2q_sim.campaigns.falsification.postconditions.run_ticks import RunTicks, over_ticks
from q2q_sim.campaigns.random_runs.random_run import Run
from q2q_sim.monitors.policies import Violation

OK_AGE_MAX = FallbackParams().degraded_after_s + TICK_S
"""Largest age of a state on which a command may be OK [s]."""
HOLD_S = PidParams().hold_duration + 3.0 * TICK_S
"""Longest hold [s]: hold_duration, and the ticks in which it begins and ends."""


def stale_reported_ok(_: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the vehicles whose command is OK though their state says that it is old."""
    age = over_ticks(ticks.states, "age")
    reported_ok = np.where(ticks.command_status <= CommandStatus.SATURATED, age, 0.0)
    k, row = np.unravel_index(int(reported_ok.argmax()), reported_ok.shape)
    oldest = float(reported_ok[k, row])
    found = (Violation("stale_reported_ok", ticks.names[row], float(ticks.t[k]), oldest, OK_AGE_MAX),)
    return PostconditionOutcome(found if oldest > OK_AGE_MAX else (), (OK_AGE_MAX - oldest) / OK_AGE_MAX)


def repeat_reported_ok(_: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the repeated commands that are reported as computed ones."""
    values = np.stack([over_ticks(ticks.commands, one) for one in ("thrust", "roll", "pitch", "yaw_rate")])
    pos = over_ticks(ticks.states, "pos")
    alike = (pos[1:] == pos[:-1]).all(axis=2) & ticks.newer[1:, None]
    same = (values[:, 1:] == values[:, :-1]).all(axis=0) & (ticks.stamp[1:] != ticks.stamp[:-1])[:, None]
    same &= ~alike
    computed = ticks.command_status == CommandStatus.OK
    bad = same & computed[1:] & computed[:-1]
    return PostconditionOutcome(
        tuple(
            Violation(
                "repeat_reported_ok",
                name,
                float(ticks.t[1 + bad[:, row].argmax()]),
                float(bad[:, row].sum()),
                0.0,
            )
            for row, name in enumerate(ticks.names)
            if bad[:, row].any()
        )
    )


def hold_too_long(run: Run, ticks: RunTicks) -> PostconditionOutcome:
    """Return the vehicles that wait for too long, by the stamps of their commands."""
    set_back = sum(fault.kind == "clock_jump" for fault in run.scenario.faults)
    limit = HOLD_S * (1 + set_back)
    found, longest, track = [], 0.0, over_ticks(ticks.states, "status")
    for row, name in enumerate(ticks.names):
        status = ticks.command_status[:, row]
        stalled = (status == CommandStatus.LEVEL) & ~ticks.newer & (track[:, row] != TrackStatus.LOST)
        waiting = (status == CommandStatus.HOLD) | stalled
        for begin, end in runs_of_true(waiting):
            held = len(np.unique(ticks.stamp[begin:end])) * TICK_S
            longest = max(longest, held)
            if held > limit:
                found.append(Violation("hold_too_long", name, float(ticks.t[begin]), held, limit))
    return PostconditionOutcome(tuple(found), (limit - longest) / limit)
