"""Policies on commands: thrust and tilt within bounds, all numbers finite."""

import numpy as np

from q2q_sim.monitors.policies.evidence import Evidence
from q2q_sim.monitors.policies.violations import Circumstances, Violation, worst_violations


def thrust(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles with a commanded thrust below 0 or above their largest."""
    most, slack = circumstances.vehicle.thrust_max, circumstances.limits.thrust_slack
    beyond = np.maximum(evidence.thrust - most, -evidence.thrust) - slack
    return worst_violations("thrust", evidence, beyond, (evidence.thrust, most))


def tilt(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles with too large a commanded tilt: cos(tilt) = cos(roll) cos(pitch)."""
    lean = np.arccos(np.clip(np.cos(evidence.roll) * np.cos(evidence.pitch), -1.0, 1.0))
    limit = circumstances.limits.tilt_max
    return worst_violations("tilt", evidence, lean - limit, (lean, limit))


def numbers(evidence: Evidence, _: Circumstances) -> list[Violation]:
    """Return the topics with numbers that are not finite."""
    return [Violation("numbers", what, float("nan"), float("nan"), 0.0) for what in evidence.not_finite]
