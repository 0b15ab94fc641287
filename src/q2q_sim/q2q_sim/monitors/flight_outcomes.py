"""Outcomes of a flight: vehicles that collided, did not take off, hit the floor or left their paths.

They are judged by true positions and by the limits of the policies `separation`, `floor` and
`setpoint_error` alone. Policies allow for displaced markers, and exempt vehicles that no command can hold:
what then happens is an outcome all the same, and its words say why policies do not count it. Its time is that
at which the limit was first exceeded, its size the worst.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from q2q_sim.monitors.flight_verdict import Finding
from q2q_sim.monitors.policies import Circumstances, judge
from q2q_sim.monitors.policies.floor import falls, floor
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace
from q2q_sim.monitors.policies.inputs.limits import Limits
from q2q_sim.monitors.policies.separation import close_pairs, separation
from q2q_sim.monitors.policies.tracking import setpoint_distances, setpoint_error

IN_FLIGHT = {"separation": separation, "floor": floor, "setpoint_error": setpoint_error}
"""Policies that decide on the outcome of a flight."""

EXEMPT = " (no command could prevent it: policies exempt it)"
DISPLACED = " (a marker was displaced: policies allow for it)"
"""Said of what the policies do not find (q2q_sim.monitors.policies.exemptions)."""


class _Outcome(NamedTuple):
    """Outcome for a vehicle or pair."""

    policy: str
    who: str
    what: str
    t: float
    """When it began [s]."""
    size: str = ""
    """How bad it became, in words."""


def outcomes(trace: FlightTrace, circumstances: Circumstances, begin: float) -> Iterator[Finding]:
    """Yield collisions, falls and departures from the path; words count time from `begin` [s]."""
    controllable = replace(circumstances, exempts_uncontrollable=False)
    found = [
        *_collisions(trace, circumstances.limits),
        *_falls(trace, replace(controllable, faults=()), begin),
        *_departures(trace, circumstances.limits),
    ]
    if not found:
        return
    judged, in_place = _found_by(trace, circumstances), _found_by(trace, controllable)
    for one in found:
        of = (one.policy, one.who)
        exempt = "" if of in judged else EXEMPT if of in in_place else DISPLACED
        yield Finding(one.t, f"{one.who} {one.what} at {one.t - begin:.1f} s{one.size}{exempt}")


def _collisions(trace: FlightTrace, limits: Limits) -> Iterator[_Outcome]:
    for (i, j), apart in close_pairs(trace.true_pos, limits.separation):
        who, first = f"{trace.names[i]} and {trace.names[j]}", int(np.argmax(apart < limits.separation))
        size = f", down to {np.nanmin(apart):.2f} m apart"
        yield _Outcome("separation", who, "collided", float(trace.t[first]), size)


def _falls(trace: FlightTrace, circumstances: Circumstances, begin: float) -> Iterator[_Outcome]:
    """Yield the first fall of each vehicle, and before it that the vehicle did not take off, or did so late.

    Only a recording from its begin shows that a vehicle on the floor has not flown before.
    """
    risen = trace.true_pos[..., 2] > circumstances.limits.take_off
    for row, ticks in falls(trace, circumstances).items():
        name, stood = trace.names[row], trace.t[0] == begin and not risen[: ticks[0], row].any()
        if stood:
            what = "was still on the floor" if risen[:, row].any() else "did not take off"
            yield _Outcome("floor", name, what, float(trace.t[ticks[0]]))
        if fallen := ticks[1:] if stood else ticks:
            yield _Outcome("floor", name, "hit the floor", float(trace.t[fallen[0]]))


def _departures(trace: FlightTrace, limits: Limits) -> Iterator[_Outcome]:
    off = setpoint_distances(trace, limits)
    away = off > limits.setpoint_error_max
    for row in np.flatnonzero(away.any(axis=0)).tolist():
        size = f", up to {np.nanmax(off[:, row]):.2f} m from its setpoint"
        first = float(trace.t[int(np.argmax(away[:, row]))])
        yield _Outcome("setpoint_error", trace.names[row], "left its path", first, size)


def _found_by(trace: FlightTrace, circumstances: Circumstances) -> set[tuple[str, str]]:
    """Return policy and vehicles of what the policies find under some circumstances."""
    return {(one.policy, one.who) for one in judge(trace, circumstances, IN_FLIGHT)}
