"""What a replanner cannot repair in its setpoints, for its log: broken promises, and what is not finite."""

from math import isfinite

import numpy as np

from q2q_model.counted import listed
from q2q_model.signals.clock_resets import SET_BACK_S
from q2q_model.signals.values import PROMISE_BROKEN, Mask, Names, SwarmSetpoint
from q2q_planner.online.finite_setpoints import nonfinite_rows

SETTLED_S = 10.0
"""Time of sound setpoints after which a warning is reported as over, and again if it comes back [s]."""


class SetpointWarnings:
    """Warning of the last setpoints, and whether it was reported."""

    def __init__(self) -> None:
        self.text = ""
        """Warning of the last setpoints; empty if there is none."""
        self._t = -np.inf  # stamp of the last setpoints [s]
        self._warned = -np.inf  # that of the last ones with a warning, until it is reported as over [s]

    def update(self, setpoint: SwarmSetpoint) -> str:
        """Return what to log of new setpoints; empty if nothing has changed."""
        self.text = setpoint_warning(setpoint)
        step, self._t = setpoint.t - self._t, setpoint.t
        reported = self._warned > -np.inf
        if self.text:
            self._warned = setpoint.t
            return "" if reported else self.text
        if reported and abs(step) > SET_BACK_S:
            self._warned += step  # to or from a wrong stamp, or a clock that is set: no time has passed
        if reported and setpoint.t - self._warned > SETTLED_S:
            self._warned = -np.inf
            return f"setpoints have been good for {SETTLED_S:g} s"
        return ""


def setpoint_warning(setpoint: SwarmSetpoint) -> str:
    """Return what is wrong with setpoints, with the vehicles; empty if nothing is."""
    broken = setpoint.status == PROMISE_BROKEN
    if _is_finite(setpoint) and not np.count_nonzero(broken):
        return ""
    endless = nonfinite_rows(setpoint)
    found = _of(setpoint.names, broken, "promise broken"), _of(setpoint.names, endless, "no finite setpoint")
    return "; ".join(filter(None, found))


def _is_finite(setpoint: SwarmSetpoint) -> bool:
    """Return whether all numbers are finite; false, too, for finite ones whose sum is not."""
    fields = setpoint.pos, setpoint.vel, setpoint.acc, setpoint.yaw, setpoint.yaw_rate
    return all(isfinite(values.sum()) for values in fields)


def _of(names: Names, which: Mask, what: str) -> str:
    """Return the vehicles of a warning, and what is wrong."""
    rows = np.flatnonzero(which)
    return f"{what}: {listed([names[row] for row in rows])}" if rows.size else ""
