"""Check of a flight against every policy."""

from collections.abc import Mapping

import numpy as np

from q2q_sim.monitors.policies import ages, command_bounds, floor, separation, tracking
from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace
from q2q_sim.monitors.policies.violations import Policy, Violation

POLICIES: Mapping[str, Policy] = {
    "separation": separation.separation,
    "zone": separation.zone,
    "setpoint_error": tracking.setpoint_error,
    "floor": floor.floor,
    "thrust": command_bounds.thrust,
    "tilt": command_bounds.tilt,
    "numbers": command_bounds.numbers,
    "state_age": ages.state_age,
    "fallback_latency": ages.fallback_latency,
    "silence": ages.silence,
    "state_error": tracking.state_error,
    "return": tracking.return_to_path,
}
"""Policies by name."""
NEEDS: Mapping[str, tuple[str, ...]] = {
    "separation": ("true_pos",),
    "zone": ("true_pos", "sent_pos"),
    "setpoint_error": ("true_pos", "sent_pos"),
    "floor": ("true_pos", "sent_pos"),
    "thrust": ("thrust",),
    "tilt": ("roll", "pitch"),
    "state_age": ("state_age", "command_status"),
    "fallback_latency": ("seen", "command_status"),
    "state_error": ("true_pos", "state_pos", "state_status"),
    "return": ("true_pos", "sent_pos", "command_status"),
}
"""Arrays of the trace without which a policy judges nothing; the others need none."""


def judge(
    trace: FlightTrace, circumstances: Circumstances, policies: Mapping[str, Policy] = POLICIES
) -> tuple[Violation, ...]:
    """Return all violations of a flight, policy by policy."""
    return tuple(found for policy in policies.values() for found in policy(trace, circumstances))


def policies_without_evidence(trace: FlightTrace) -> tuple[str, ...]:
    """Return the policies of which a flight has no evidence, in which nothing can be violated."""
    return tuple(
        policy
        for policy in POLICIES
        if any(not _has(trace, name) for name in NEEDS.get(policy, ()))
        or (policy == "silence" and not any(len(at) > 1 for at in trace.commanded_at.values()))
    )


def _has(trace: FlightTrace, name: str) -> bool:
    values = getattr(trace, name)
    return bool(values.any()) if values.dtype == np.bool_ else bool(np.isfinite(values).any())
