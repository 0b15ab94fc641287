"""Margins of the policies: how far a flight stays from violating each, for a search of the worst.

The margin of a policy is the robustness of its property, as in signal temporal logic (Fainekos and Pappas,
2009): the smallest distance from the limit over vehicles and time, here divided by the limit. It is negative
if the policy is violated, and infinite where nothing was judged.

    |value| <= limit:   margin = min (limit - value) / limit
    value >= limit:     margin = min (value - limit) / limit
    zone:               margin = min distance / stray

The worst values come from the policies themselves, judged with limits that nothing keeps. The others (thrust,
numbers, floor, silence) have a verdict only: thrust saturates at its limit, numbers are finite or not, a fall
leaves the room before it ends, and the pure loop has no wall time.
"""

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace
from q2q_sim.monitors.policies.inputs.limits import Limits
from q2q_sim.monitors.policies.judgement import POLICIES
from q2q_sim.monitors.policies.separation import clearances
from q2q_sim.monitors.policies.violations import Violation

MOST = {
    "setpoint_error": "setpoint_error_max",
    "tilt": "tilt_max",
    "state_age": "state_age_max",
    "fallback_latency": "fallback_latency_max",
    "state_error": "state_error_max",
    "return": "back",
}
"""Policies whose value must stay below a limit, and the limit's name."""
FAR = 1e3
"""Distance that every pair is nearer than [m]."""


def margins(trace: FlightTrace, circumstances: Circumstances) -> Mapping[str, float]:
    """Return the margin of every policy that has one."""
    limits = circumstances.limits
    strict = replace(circumstances, limits=_kept_by_none(limits))
    found = {name: _below(POLICIES[name](trace, strict), _limit(limits, name)) for name in MOST}
    nearest = min((one.value for one in POLICIES["separation"](trace, strict)), default=np.inf)
    found["separation"] = nearest / limits.separation - 1.0
    pairs = list(combinations(range(len(trace.names)), 2))
    known = [inside[np.isfinite(inside)] for _, inside in clearances(trace, circumstances, pairs)]
    found["zone"] = min((float(one.min()) for one in known if len(one)), default=np.inf) / limits.stray
    return found


def _kept_by_none(limits: Limits) -> Limits:
    return replace(
        limits,
        setpoint_error_max=0.0,
        tilt_max=0.0,
        state_age_max=0.0,
        fallback_latency_max=0.0,
        state_error_max=0.0,
        back=0.0,
        separation=FAR,
    )


def _limit(limits: Limits, policy: str) -> float:
    return float(getattr(limits, MOST[policy]))


def _below(worst: list[Violation], limit: float) -> float:
    return min(((limit - one.value) / limit for one in worst), default=np.inf)
