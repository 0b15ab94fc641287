"""One-line verdict on a flight: ok, or the first failure with its place and time.

| finding | judged by |
|---|---|
| a vehicle hit the floor | policy `floor` |
| a vehicle landed without feedback, or its motors were cut | its commands: LAND on the floor, CUT |
| two vehicles collided | policy `separation` |
| a vehicle left its path | policy `room` |
| commands ended before the flight | a vehicle's last command older than the firmware's watchdog, 0.5 s |
| ticks were missed | more than 1 % without a command in time, of a vehicle that ever had one |
| the recording ends before the flight | a bag that was not closed (`with_unknown_end`) |
| the flight ended early | the length that was to be flown, in the bag's metadata (`with_planned_end`) |

The other policies check guarantees of the stack (`policies BAG`), not the outcome of the flight. Policies
excuse vehicles that no command carries; what happened to them is a failure here, with that reason. Times in
words are those since the first tick of the recording.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.signals.values import CommandStatus, Mask
from q2q_sim.monitors.metrics import tick_period
from q2q_sim.monitors.policies import Circumstances, Violation, judge
from q2q_sim.monitors.policies.flight_trace import FlightTrace
from q2q_sim.monitors.policies.floor import floor, touches_floor
from q2q_sim.monitors.policies.separation import separation
from q2q_sim.monitors.policies.trace_from_arrays import trace_from_arrays
from q2q_sim.monitors.policies.tracking import room

MISSED_SHARE = 0.01
"""Largest fraction of ticks without a command in time [-]."""
COMMANDS_END_S = 0.5
"""Time without commands after which the Crazyflie firmware levels out [s] (q2q_sim.link.radio)."""
EARLY_S = 0.5
"""Time that a flight to the end may lack [s]: live, the last ticks are lost when the nodes end."""
UNSEEN_S = 0.5
"""Time without a position of a vehicle from which it is reported [s]: longer than the dropouts of a room."""
IN_FLIGHT = {"separation": separation, "floor": floor, "room": room}
"""Policies that decide on the outcome of a flight."""
WORDS = {"separation": "collided", "floor": "hit the floor", "room": "left its path"}

EXCUSED = " (no command could prevent it: policies excuse it)"
"""Said of what the policies do not judge (q2q_sim.monitors.policies.exemptions)."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One failure in a flight."""

    t: float
    """Stamp [s]."""
    words: str
    """With the time since the first tick [s]."""


@dataclass(frozen=True, slots=True)
class FlightVerdict:
    """Outcome of a flight: failures in order of time, and what could not be judged."""

    duration: float
    """[s]"""
    findings: tuple[Finding, ...] = ()
    unjudged: tuple[str, ...] = ()
    """Quantities missing from the recording."""
    is_part: bool = False
    """Whether a part of a flight was judged, which says nothing of its end."""

    @property
    def ok(self) -> bool:
        """Return whether nothing went wrong."""
        return not self.findings

    def __str__(self) -> str:
        """Return one line."""
        if self.findings:
            return "; ".join(one.words for one in self.findings)
        how = "judged, a part of the flight" if self.is_part else "flown to the end"
        known = f"ok: {self.duration:.1f} s {how}"
        return "; ".join([known, *(f"not judged: {one}" for one in self.unjudged)])


def verdict_of(
    flight: Flight,
    circumstances: Circumstances,
    missed_ticks: int | None = None,
    begin: float | None = None,
) -> FlightVerdict:
    """Return the verdict on a flight.

    Args:
        flight: recording of the flight.
        circumstances: its vehicle and faults, as for the policies.
        missed_ticks: ticks whose command was late or missing; None counts those without a command.
        begin: stamp of the first tick of the whole recording, if this is a part of it [s].
    """
    if not len(flight.t):
        return FlightVerdict(0.0, (Finding(0.0, "no tick was flown"),))
    trace, is_part = trace_from_arrays(flight), begin is not None
    begin = float(flight.t[0]) if begin is None else begin
    found = [
        *_broken(trace, circumstances, begin),
        *_sent_down(trace, circumstances, begin),
        *_commands_ended(trace, begin),
        *_missed(trace, missed_ticks),
    ]
    found.sort(key=lambda one: one.t)
    return FlightVerdict(_duration(flight), tuple(found), tuple(_unjudged(trace, begin)), is_part)


def with_lost_ticks(verdict: FlightVerdict, flight: Flight, flown: int) -> FlightVerdict:
    """Return a verdict that names how many of the ticks flown the recording lacks."""
    lost = flown - len(flight.t)
    if lost <= 0:
        return verdict
    words = f"{lost} of {flown} ticks, which the recording lacks"
    return replace(verdict, unjudged=(*verdict.unjudged, words))


def with_finding(verdict: FlightVerdict, finding: Finding) -> FlightVerdict:
    """Return a verdict with a further failure."""
    found = sorted((*verdict.findings, finding), key=lambda one: one.t)
    return replace(verdict, findings=tuple(found))


def with_end(verdict: FlightVerdict, flight: Flight, planned: str, *, is_cut: bool) -> FlightVerdict:
    """Return the verdict on all of a recording: one that was cut off, or was to last `planned` [s]."""
    return with_unknown_end(verdict, flight) if is_cut else with_planned_end(verdict, flight, planned)


def with_unknown_end(verdict: FlightVerdict, flight: Flight) -> FlightVerdict:
    """Return the verdict on a flight whose recording was cut off, by a kill or a full disk."""
    words = f"the recording was cut off at {flight.t[-1] - flight.t[0]:.1f} s: its end is unknown"
    return with_finding(verdict, Finding(float(flight.t[-1]), words))


def with_planned_end(verdict: FlightVerdict, flight: Flight, planned: str) -> FlightVerdict:
    """Return the verdict on a flight that was to last `planned` [s]; empty or no number is unknown.

    A recording may begin after its flight: a stamp up to the planned end is the time since the start.
    """
    end = float(flight.t[-1])
    try:
        begins_late = end < float(planned) + EARLY_S
    except ValueError:
        return verdict
    flown = max(_duration(flight), end) if begins_late else _duration(flight)
    if not float(planned) - flown > EARLY_S:
        return verdict
    words = f"the flight ended at {flown:.1f} s of {float(planned):.1f} s, before its end"
    return with_finding(verdict, Finding(end, words))


def verdict_line(flights: Sequence[tuple[str, FlightVerdict]]) -> str:
    """Return the verdicts on named flights in one line; without the name for a single flight."""
    if len(flights) == 1:
        return f"verdict: {flights[0][1]}"
    return "verdict: " + " | ".join(f"{name}: {verdict}" for name, verdict in flights)


def _broken(trace: FlightTrace, circumstances: Circumstances, begin: float) -> Iterator[Finding]:
    """Yield what policies find, falls when they began; and what they excuse, of whom they find nothing."""
    broken = judge(trace, replace(circumstances, excuses_helpless=False), IN_FLIGHT)
    with_excuses = judge(trace, circumstances, IN_FLIGHT) if broken else ()
    judged = {(one.policy, one.who): one for one in with_excuses}
    for one in broken:
        found = judged.get((one.policy, one.who))
        told = one if found is None or one.policy == "floor" else found
        yield Finding(told.t, _words(told, begin) + (EXCUSED if found is None else ""))


def _words(broken: Violation, begin: float) -> str:
    text = f"{broken.who} {WORDS[broken.policy]} at {broken.t - begin:.1f} s"
    if broken.policy == "floor":
        return text
    measure = "apart" if broken.policy == "separation" else "from its setpoint"
    return f"{text}, {broken.value:.2f} m {measure}"


def _sent_down(trace: FlightTrace, circumstances: Circumstances, begin: float) -> Iterator[Finding]:
    """Yield the vehicles that their controller brought to the floor, away from their plan."""
    status = trace.command_status
    landed = touches_floor(trace, circumstances.limits)
    for row, name in enumerate(trace.names):
        ends = {
            "motors were cut": status[:, row] == CommandStatus.CUT,
            "landed blind": (status[:, row] == CommandStatus.LAND) & landed[:, row],
        }
        first = {words: trace.t[mask][0] for words, mask in ends.items() if mask.any()}
        for words, t in sorted(first.items(), key=lambda one: one[1])[:1]:
            owner = f"{name}'s" if words.startswith("motors") else name
            yield Finding(float(t), f"{owner} {words} at {t - begin:.1f} s")


def _commands_ended(trace: FlightTrace, begin: float) -> Iterator[Finding]:
    """Yield the vehicles whose commands ended before the flight; all at once, if theirs ended together."""
    t = trace.t
    last = {name: float(t[given][-1]) for name, given in _commanded(trace).items()}
    for name, at in _once_if_of_all(last).items():
        if t[-1] - at > COMMANDS_END_S:
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
        yield "floor, room and distances (no state or truth recorded)"
    elif not np.isfinite(trace.sent_pos).any():
        yield "floor and room (no reference recorded)"
    if not np.isfinite(trace.command_status).any():
        yield "missed ticks (no command recorded)"
    if np.isfinite(trace.true_pos).any():
        yield from _unseen(trace, begin)


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


def _duration(flight: Flight) -> float:
    tick = tick_period(flight)
    return float(flight.t[-1] - flight.t[0]) + (tick if np.isfinite(tick) else 0.0)
