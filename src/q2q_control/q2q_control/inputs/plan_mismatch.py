"""Mismatch of a plan that comes and the setpoints, as the first setpoint after it shows.

A preview of another plan, or of one in other time, is not followed: setpoints off their plan are extrapolated
(q2q_control.inputs.preview). A replanner moves setpoints off their plan later: only the first is compared.
"""

import numpy as np

from q2q_control.inputs.far_setpoints import far_apart, in_words
from q2q_control.inputs.preview import SampledPreview
from q2q_model.signals.values import SwarmSetpoint

OVER_S = 1.0
"""Time for which a plan that comes may be over [s]: a short one, as of braking, ends before it has come."""


def plan_mismatch(plan: SampledPreview, setpoint: SwarmSetpoint) -> str:
    """Return why a plan that has come cannot be that of a setpoint; empty if it can."""
    over = setpoint.t - (plan.start + plan.step * (plan.samples.shape[1] - 1))
    found = []
    if over > OVER_S:
        found.append(f"it ended {over:.1f} s before it came: does it start by the stamps of mocap?")
    planned = plan.at(setpoint.names, np.array([setpoint.t]))[:, 0, :3]
    far = far_apart(setpoint.names, planned, setpoint.pos)
    if far:
        found.append(f"it is far from the setpoints: {in_words(far)}: is it the plan they come from?")
    return f"plan: {' '.join(found)}" if found else ""


class PlanMismatchMonitor:
    """Plan that came after the last setpoint, to be compared with the next one."""

    def __init__(self) -> None:
        self._new: SampledPreview | None = None

    def take_plan(self, plan: SampledPreview) -> None:
        """Take a plan that has come."""
        self._new = plan

    def look(self, setpoint: SwarmSetpoint) -> str:
        """Return `plan_mismatch` of a plan with the first setpoint after it; empty for later ones."""
        if self._new is None:
            return ""
        new, self._new = self._new, None
        return plan_mismatch(new, setpoint)
