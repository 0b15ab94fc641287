"""Outcomes of a flight: vehicles that collided, hit the floor or left their paths.

They are judged by true positions and by the limits of the policies `separation`, `floor` and
`setpoint_error` alone. Policies allow for displaced markers, and exempt vehicles that no command can hold:
what then happens is an outcome all the same, and its words say why policies do not count it.
"""

from collections.abc import Iterator
from dataclasses import replace

from q2q_sim.monitors.flight_verdict import Finding
from q2q_sim.monitors.policies import Circumstances, Violation, judge
from q2q_sim.monitors.policies.floor import floor
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace
from q2q_sim.monitors.policies.separation import separation
from q2q_sim.monitors.policies.tracking import setpoint_error

IN_FLIGHT = {"separation": separation, "floor": floor, "setpoint_error": setpoint_error}
"""Policies that decide on the outcome of a flight."""
WORDS = {"separation": "collided", "floor": "hit the floor", "setpoint_error": "left its path"}

EXEMPT = " (no command could prevent it: policies exempt it)"
DISPLACED = " (a marker was displaced: policies allow for it)"
"""Said of what the policies do not find (q2q_sim.monitors.policies.exemptions)."""


def outcomes(trace: FlightTrace, circumstances: Circumstances, begin: float) -> Iterator[Finding]:
    """Yield collisions, falls and departures from the path; words count time from `begin` [s]."""
    uncontrollable_too = replace(circumstances, exempts_uncontrollable=False)
    found = judge(trace, replace(uncontrollable_too, faults=()), IN_FLIGHT)
    if not found:
        return
    judged, in_place = _found_by(trace, circumstances), _found_by(trace, uncontrollable_too)
    for one in found:
        of = (one.policy, one.who)
        exempt = "" if of in judged else EXEMPT if of in in_place else DISPLACED
        yield Finding(one.t, _words(one, begin) + exempt)


def _found_by(trace: FlightTrace, circumstances: Circumstances) -> set[tuple[str, str]]:
    """Return policy and vehicles of what the policies find under some circumstances."""
    return {(one.policy, one.who) for one in judge(trace, circumstances, IN_FLIGHT)}


def _words(broken: Violation, begin: float) -> str:
    text = f"{broken.who} {WORDS[broken.policy]} at {broken.t - begin:.1f} s"
    if broken.policy == "floor":
        return text
    measure = "apart" if broken.policy == "separation" else "from its setpoint"
    return f"{text}, {broken.value:.2f} m {measure}"
