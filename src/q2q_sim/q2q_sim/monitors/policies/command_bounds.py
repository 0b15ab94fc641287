"""Policies on commands: thrust and tilt within bounds, all numbers finite."""

import numpy as np

from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace
from q2q_sim.monitors.policies.violations import Violation, worst_violations


def thrust(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles with a commanded thrust below 0 or above their largest."""
    most, slack = circumstances.vehicle.thrust_max, circumstances.limits.thrust_slack
    beyond = np.maximum(trace.thrust - most, -trace.thrust) - slack
    return worst_violations("thrust", trace, beyond, (trace.thrust, most))


def tilt(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles with too large a commanded tilt: cos(tilt) = cos(roll) cos(pitch)."""
    lean = np.arccos(np.clip(np.cos(trace.roll) * np.cos(trace.pitch), -1.0, 1.0))
    limit = circumstances.limits.tilt_max
    return worst_violations("tilt", trace, lean - limit, (lean, limit))


def numbers(trace: FlightTrace, _: Circumstances) -> list[Violation]:
    """Return the topics with numbers that are not finite."""
    return [Violation("numbers", what, float("nan"), float("nan"), 0.0) for what in trace.not_finite]
