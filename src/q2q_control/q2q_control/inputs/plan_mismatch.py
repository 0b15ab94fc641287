"""Whether a plan that comes is that of the setpoints, as the setpoints after it show.

A preview of another plan, or of one in other time, is not followed: setpoints off their plan are extrapolated
(q2q_control.inputs.preview).

| plan when it comes | compared with | reported |
|---|---|---|
| begins a year or more before or after a setpoint | its stamp | until the next plan |
| runs, or begins later | the first setpoint: a replanner may move later ones | until setpoints are near it |
| is over | every setpoint | while they are far from its end |

Setpoints near the end of a plan that is over hold there, as they do for a controller that starts after the
plan has ended: nothing is wrong. A plan of another time base (one clock counts since 1970, one since its
machine started) would be taken for such a one, or for one that begins later. A clock that is wrong by less
than a year is not reported while the setpoints stay near the plan's end.
"""

import numpy as np

from q2q_control.inputs.far_setpoints import distances_text, far_apart
from q2q_control.inputs.preview import SampledPreview
from q2q_model.signals.values import SwarmSetpoint

OVER_S = 1.0
"""Time for which a plan that comes may be over [s]: a short one, as of braking, ends before it has come."""
YEAR_S = 3.2e7
"""Time between a plan and a setpoint from which on their stamps are not of one clock [s]."""
_ELSEWHERE = "plan: far from the setpoints: {}: check that they come from this plan"
_OVER = (
    "plan: ended {:.1f} s before it arrived, far from the setpoints: {}: it is from an earlier flight, or "
    "its start is not in the time of mocap"
)
_OTHER_CLOCK = (
    "plan: starts at {:.0f} s, but the setpoints are at {:.0f} s: check that their nodes use one clock"
)


def far_from_plan(plan: SampledPreview, setpoint: SwarmSetpoint) -> str:
    """Return the vehicles whose setpoints are FAR_M or more from their plan, and how far; empty for none."""
    planned = plan.at(setpoint.names, np.array([setpoint.t]))[:, 0, :3]
    return distances_text(far_apart(setpoint.names, planned, setpoint.pos))


class PlanMismatchMonitor:
    """Newest plan, and whether the setpoints since it came are far from it."""

    def __init__(self) -> None:
        self._plan: SampledPreview | None = None  # still to be compared
        self._over: float | None = None  # when it came [s]; None before the first setpoint
        self._message, self._is_new = "", True

    def take_plan(self, plan: SampledPreview) -> None:
        """Take a plan, to compare it with the setpoints from now on."""
        self._plan, self._over = plan, None
        self._message, self._is_new = "", True

    def update(self, setpoint: SwarmSetpoint) -> tuple[str, bool]:
        """Return what is wrong with the plan, empty if nothing is, and whether it was not reported before."""
        plan = self._plan
        if plan is None:
            return "", False
        if self._over is None:
            self._over = setpoint.t - (plan.start + plan.step * (plan.samples.shape[1] - 1))
        is_over = self._over > OVER_S
        if abs(plan.start - setpoint.t) > YEAR_S:
            return self._report(_OTHER_CLOCK.format(plan.start, setpoint.t))
        if far := far_from_plan(plan, setpoint):
            return self._report(_OVER.format(self._over, far) if is_over else _ELSEWHERE.format(far))
        self._message, self._plan = "", plan if is_over else None
        return "", False

    def _report(self, message: str) -> tuple[str, bool]:
        """Return what was reported first since all was well, and whether nothing of this plan was before."""
        self._message = self._message or message
        is_new, self._is_new = self._is_new, False
        return self._message, is_new
