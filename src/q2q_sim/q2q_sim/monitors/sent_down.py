"""Vehicles that their controller brought down, away from their plan, or flew without feedback to the end.

| finding | commands |
|---|---|
| motors were cut | CUT |
| motors were cut by an emergency stop | CUT right after OK, SATURATED or DEGRADED |
| landed without measurements | LAND on the floor |
| was never measured | from the first to the last, or to CUT, LEVEL or LAND |
| was flown without measurements to the end | the last is LAND |

The failsafe (q2q_control.failsafe.fallback_phases) cuts after LAND, after LEVEL where land_after_s is
cut_after_s, or after HOLD where a clock was set ahead by seconds, and an emergency stop at any time: a cut
right after one of these, or after a gap in the recording, is reported without a cause.

Only the whole recording shows that a vehicle was never measured, and only a part up to its end how it ended.
A vehicle has C recorded commands; ticks without one do not count.
"""

from collections.abc import Iterator

import numpy as np

from q2q_model.signals.values import Array, CommandStatus
from q2q_model.vehicle.setpoint_watchdog import LEVEL_AFTER_S
from q2q_sim.monitors.flight_verdict import Finding
from q2q_sim.monitors.policies import Limits
from q2q_sim.monitors.policies.floor import touches_floor
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace

WITHOUT_FEEDBACK = (CommandStatus.LEVEL, CommandStatus.LAND)
"""Commands without feedback beyond HOLD, which is short and follows a measurement."""
BEFORE_FAILSAFE_CUT = (CommandStatus.HOLD, CommandStatus.LEVEL, CommandStatus.LAND)
"""Commands right after which the failsafe may cut."""


def sent_down(trace: FlightTrace, limits: Limits, stamps: Array) -> Iterator[Finding]:
    """Yield the vehicles sent down or not measured to the end; `stamps` are all of a recording [s], (K,)."""
    begin, is_whole, reaches_end = stamps[0], len(trace.t) == len(stamps), trace.t[-1] == stamps[-1]
    down = touches_floor(trace, limits)
    for row, name in enumerate(trace.names):
        status = trace.command_status[:, row]
        given = np.isfinite(status)
        t, commands = trace.t[given], status[given]
        never = is_whole and _is_never_measured(commands)
        if never:
            yield Finding(float(trace.t[0]), f"{name} was never measured")
        cause = " by an emergency stop" if _is_emergency_stop(t, commands) else ""
        ends = {
            f"{name}'s motors were cut{cause}": status == CommandStatus.CUT,
            f"{name} landed without measurements": (status == CommandStatus.LAND) & down[:, row],
        }
        first = {words: float(trace.t[mask][0]) for words, mask in ends.items() if mask.any()}
        for words, at in sorted(first.items(), key=lambda one: one[1])[:1]:
            yield Finding(at, f"{words} at {at - begin:.1f} s")
        if reaches_end and not first and not never and (since := _unmeasured_since(t, commands)) is not None:
            yield Finding(since, f"{name} flew without measurements from {since - begin:.1f} s to the end")


def _is_never_measured(status: Array) -> bool:
    """Return whether none of a vehicle's commands, (C,), has feedback, and some are not CUT."""
    flown = status[status != CommandStatus.CUT]
    return bool(len(flown)) and bool(np.isin(flown, WITHOUT_FEEDBACK).all())


def _is_emergency_stop(t: Array, status: Array) -> bool:
    """Return whether only an emergency stop can be a vehicle's first CUT; t and status are (C,)."""
    first = int((status != CommandStatus.CUT).cumprod().sum())
    if first in (0, len(t)) or t[first] - t[first - 1] > LEVEL_AFTER_S:
        return False
    return status[first - 1] not in BEFORE_FAILSAFE_CUT


def _unmeasured_since(t: Array, status: Array) -> float | None:
    """Return since when a vehicle had no feedback [s], if its last command is LAND; t and status are (C,)."""
    if not len(t) or status[-1] != CommandStatus.LAND:
        return None
    seen = np.flatnonzero(~np.isin(status, WITHOUT_FEEDBACK))
    return float(t[seen[-1] + 1 if len(seen) else 0])
