"""Judgement of a flight: what went wrong, and what could not be judged.

| finding | judged by |
|---|---|
| a vehicle hit the floor, or did not take off, or late | policy `floor` |
| a vehicle landed or was flown to the end without measurements, or never had any | sent_down.py |
| motors were cut, by an emergency stop or by the failsafe | sent_down.py |
| two vehicles collided | policy `separation` |
| a vehicle left its path | policy `setpoint_error` |
| commands ended before the flight | a vehicle's last command older than the firmware's watchdog, 0.5 s |
| ticks were missed | more than 1 % without a command in time, of a vehicle that ever had one |
| the recording ends before the flight | a bag that was not closed (recording_end.py) |
| the flight ended early | the length that was to be flown, in the bag's metadata (recording_end.py) |

Findings of `separation`, `floor` and `setpoint_error` are judged by the limits alone (flight_outcomes.py).
The other policies check guarantees of the stack (`policies BAG`), not the outcome of the flight. Times in
words are those since the first tick of the recording. How vehicles and commands ended is said only of what
reaches the recording's end.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Mask
from q2q_model.vehicle.setpoint_watchdog import LEVEL_AFTER_S
from q2q_sim.monitors.flight_outcomes import outcomes
from q2q_sim.monitors.flight_verdict import Finding, FlightVerdict
from q2q_sim.monitors.policies import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace
from q2q_sim.monitors.policies.inputs.trace_from_arrays import trace_from_arrays
from q2q_sim.monitors.recording_end import recorded_duration
from q2q_sim.monitors.sent_down import sent_down

MISSED_SHARE = 0.01
"""Largest fraction of ticks without a command in time [-]."""
UNSEEN_S = 0.5
"""Time without a position of a vehicle from which it is reported [s]: longer than the dropouts of a room."""


def verdict_of(
    flight: Flight,
    circumstances: Circumstances,
    missed_ticks: int | None = None,
    whole: Flight | None = None,
) -> FlightVerdict:
    """Return the verdict on a flight.

    Args:
        flight: recording of the flight.
        circumstances: its vehicle and faults, as for the policies.
        missed_ticks: ticks whose command was late or missing; None counts those without a command.
        whole: the whole recording, if this is a part of it.
    """
    if not len(flight.t):
        return FlightVerdict(0.0, (Finding(0.0, "no tick was flown"),))
    trace, stamps = trace_from_arrays(flight), (whole or flight).t
    begin, is_part = float(stamps[0]), len(flight.t) < len(stamps)
    found = [
        *outcomes(trace, circumstances, begin),
        *sent_down(trace, circumstances.limits, stamps),
        *(_commands_ended(trace, begin) if trace.t[-1] == stamps[-1] else ()),
        *_missed(trace, missed_ticks),
    ]
    found.sort(key=lambda one: one.t)
    unjudged = (*_unjudged(trace, begin), *_unmeasured(whole or flight))
    return FlightVerdict(recorded_duration(flight), tuple(found), unjudged, is_part)


def _commands_ended(trace: FlightTrace, begin: float) -> Iterator[Finding]:
    """Yield the vehicles whose commands ended before the flight; all at once, if theirs ended together."""
    t = trace.t
    last = {name: float(t[given][-1]) for name, given in _commanded(trace).items()}
    for name, at in _once_if_of_all(last).items():
        if t[-1] - at > LEVEL_AFTER_S:
            whose = f"{name}'s commands" if name else "commands"
            yield Finding(at, f"{whose} ended at {at - begin:.1f} s of {t[-1] - begin:.1f} s")


def _missed(trace: FlightTrace, counted: int | None) -> Iterator[Finding]:
    """Yield a finding if too many ticks were missed, of all vehicles or by vehicle."""
    ticks = len(trace.t)
    lacking = {name: float(ticks - given.sum()) for name, given in _commanded(trace).items()}
    missed = _once_if_of_all(lacking) if counted is None else {"": float(counted)}
    for name, count in missed.items():
        if count > MISSED_SHARE * ticks:
            which = f"ticks of {name}" if name else "ticks"
            yield Finding(float(trace.t[-1]), f"{count:.0f} of {ticks} {which} were missed")


def _commanded(trace: FlightTrace) -> Mapping[str, Mask]:
    """Return the ticks with a command, (T,), of each vehicle that ever has one."""
    given = np.isfinite(trace.command_status)
    return {name: given[:, row] for row, name in enumerate(trace.names) if given[:, row].any()}


def _once_if_of_all(values: Mapping[str, float]) -> Mapping[str, float]:
    """Return the values of vehicles; one that all of them have once, under an empty name."""
    distinct = set(values.values())
    return {"": distinct.pop()} if len(distinct) == 1 else values


def _unjudged(trace: FlightTrace, begin: float) -> Iterator[str]:
    if not np.isfinite(trace.true_pos).any():
        yield "floor, setpoint_error and distances (no state or truth recorded)"
    elif not np.isfinite(trace.sent_pos).any():
        yield "floor and setpoint_error (no reference recorded)"
    if not np.isfinite(trace.command_status).any():
        yield "missed ticks (no command recorded)"
    if np.isfinite(trace.true_pos).any():
        yield from _unseen(trace, begin)


def _unmeasured(flight: Flight) -> Iterator[str]:
    """Yield a line if a flight has positions, but none that is true or measured."""
    if np.isfinite(flight.pos).any() and not (
        np.isfinite(flight.true_pos).any() or np.isfinite(flight.mocap_pos).any()
    ):
        yield "measurements (no sample of motion capture recorded: positions are estimates)"


def _unseen(trace: FlightTrace, start: float) -> Iterator[str]:
    """Yield the longest time without a position of each vehicle that has a long one."""
    t = trace.t
    for row, name in enumerate(trace.names):
        seen = t[np.isfinite(trace.true_pos[:, row]).all(axis=1)]
        ends = np.concatenate((t[:1], seen, t[-1:]))
        longest = int(np.argmax(np.diff(ends)))
        begin, end = (ends[longest : longest + 2] - start).tolist()
        if end - begin > UNSEEN_S:
            yield f"{name} from {begin:.1f} to {end:.1f} s (no position recorded)"
