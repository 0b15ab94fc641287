"""Check of a flight against every policy."""

from collections.abc import Mapping

from q2q_sim.monitors.policies import ages, closeness, command_bounds, floor, tracking
from q2q_sim.monitors.policies.evidence import Evidence
from q2q_sim.monitors.policies.violations import Circumstances, Policy, Violation

POLICIES: Mapping[str, Policy] = {
    "separation": closeness.separation,
    "zone": closeness.zone,
    "room": tracking.room,
    "floor": floor.floor,
    "thrust": command_bounds.thrust,
    "tilt": command_bounds.tilt,
    "numbers": command_bounds.numbers,
    "age": ages.age,
    "action": ages.action,
    "silence": ages.silence,
    "belief": tracking.belief,
    "return": tracking.come_back,
}
"""Policies by name."""


def judge(
    evidence: Evidence, circumstances: Circumstances, policies: Mapping[str, Policy] = POLICIES
) -> tuple[Violation, ...]:
    """Return all violations of a flight, policy by policy."""
    return tuple(found for policy in policies.values() for found in policy(evidence, circumstances))
