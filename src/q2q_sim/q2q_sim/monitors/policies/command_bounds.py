"""Judge commands: thrust and tilt within bounds, and nothing that is no number."""

import numpy as np

from q2q_sim.monitors.policies.evidence import Evidence
from q2q_sim.monitors.policies.violations import Circumstances, Violation, worst


def thrust(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return who was commanded less than no thrust, or more than the vehicle has."""
    most, slack = circumstances.vehicle.thrust_max, circumstances.limits.thrust_slack
    beyond = np.maximum(evidence.thrust - most, -evidence.thrust) - slack
    return worst("thrust", evidence, beyond, (evidence.thrust, most))


def tilt(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return who was commanded to lean too far: cos(tilt) = cos(roll) cos(pitch)."""
    lean = np.arccos(np.clip(np.cos(evidence.roll) * np.cos(evidence.pitch), -1.0, 1.0))
    limit = circumstances.limits.tilt_max
    return worst("tilt", evidence, lean - limit, (lean, limit))


def numbers(evidence: Evidence, _: Circumstances) -> list[Violation]:
    """Return the topics that carried something that is no number."""
    return [Violation("numbers", what, float("nan"), float("nan"), 0.0) for what in evidence.nonsense]
