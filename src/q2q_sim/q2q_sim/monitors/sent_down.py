"""Vehicles that their controller brought down, away from their plan, or flew without feedback to the end.

| finding | commands | filtered position |
|---|---|---|
| motors were cut | CUT | |
| motors were cut by an emergency stop | CUT right after OK, SATURATED or DEGRADED | |
| landed without measurements | LAND on the floor | held or absent |
| landed on the failsafe's commands | LAND on the floor | measured |
| was never measured | from the first to the last, or to CUT, LEVEL or LAND | held or absent |
| was flown without measurements to the end | the last is LAND | held or absent |
| was flown on the failsafe's commands to the end | the last is LAND | measured |

The mocap filter holds the position of a vehicle that is lost. One that is measured is landed where its
controller fails, or has no setpoint or other input.

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
RECENT_S = 0.5
"""Time before the end of a landing over which the cause is looked for [s]: LAND begins 1 s after a loss."""

MOVING = 0.3
"""Least share of ticks with a new position of a vehicle that is measured, at half the ticks or more often."""
FAILSAFE = " on the failsafe's commands, although it was measured"


def sent_down(trace: FlightTrace, limits: Limits, stamps: Array) -> Iterator[Finding]:
    """Yield the vehicles sent down or not measured to the end; `stamps` are all of a recording [s], (K,)."""
    begin, is_whole, reaches_end = stamps[0], len(trace.t) == len(stamps), trace.t[-1] == stamps[-1]
    down = touches_floor(trace, limits)
    for row, name in enumerate(trace.names):
        status = trace.command_status[:, row]
        given = np.isfinite(status)
        t, commands = trace.t[given], status[given]
        never = is_whole and _is_without_feedback(commands)
        if never:
            how = (
                f"flew{FAILSAFE}, from the first command on"
                if _is_measured(trace, row)
                else "was never measured"
            )
            yield Finding(float(trace.t[0]), f"{name} {how}")
        cause = " by an emergency stop" if _is_emergency_stop(t, commands) else ""
        ends = {
            f"{name}'s motors were cut{cause}": status == CommandStatus.CUT,
            f"{name} landed": (status == CommandStatus.LAND) & down[:, row],
        }
        first = {words: float(trace.t[mask][0]) for words, mask in ends.items() if mask.any()}
        for words, at in sorted(first.items(), key=lambda one: one[1])[:1]:
            how = _without_what(trace, row, at) if words.endswith("landed") else ""
            yield Finding(at, f"{words}{how} at {at - begin:.1f} s")
        if reaches_end and not first and not never and (since := _landing_since(t, commands)) is not None:
            how = _without_what(trace, row, float(trace.t[-1]))
            yield Finding(since, f"{name} flew{how} from {since - begin:.1f} s to the end")


def _without_what(trace: FlightTrace, row: int, at: float) -> str:
    """Return in words how a vehicle was landed, from what was measured just before a time [s]."""
    measured = _is_measured(trace, row, at - RECENT_S, at)
    return f"{FAILSAFE}," if measured else " without measurements"


def _is_measured(trace: FlightTrace, row: int, begin: float = -np.inf, end: float = np.inf) -> bool:
    """Return whether the filtered position of a vehicle changes often enough in a time [s] (MOVING)."""
    known = np.flatnonzero(np.isfinite(trace.state_pos[:, row]).all(axis=1))
    pos, t = trace.state_pos[known, row], trace.t[known]
    changes = (pos[1:] != pos[:-1]).any(axis=1)[(t[1:] > begin) & (t[1:] <= end)]
    return bool(changes.sum() > MOVING * len(changes))


def _is_without_feedback(status: Array) -> bool:
    """Return whether none of a vehicle's commands, (C,), has feedback, and some are not CUT."""
    flown = status[status != CommandStatus.CUT]
    return bool(len(flown)) and bool(np.isin(flown, WITHOUT_FEEDBACK).all())


def _is_emergency_stop(t: Array, status: Array) -> bool:
    """Return whether only an emergency stop can be a vehicle's first CUT; t and status are (C,)."""
    first = int((status != CommandStatus.CUT).cumprod().sum())
    if first in (0, len(t)) or t[first] - t[first - 1] > LEVEL_AFTER_S:
        return False
    return status[first - 1] not in BEFORE_FAILSAFE_CUT


def _landing_since(t: Array, status: Array) -> float | None:
    """Return since when a vehicle had no feedback [s], if its last command is LAND; t and status are (C,)."""
    if not len(t) or status[-1] != CommandStatus.LAND:
        return None
    seen = np.flatnonzero(~np.isin(status, WITHOUT_FEEDBACK))
    return float(t[seen[-1] + 1 if len(seen) else 0])
