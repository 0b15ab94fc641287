"""Setpoints that are not finite, which no controller flies."""

import numpy as np

from q2q_model.signals.values import Mask, SwarmSetpoint


def nonfinite_rows(setpoint: SwarmSetpoint) -> Mask:
    """Return which vehicles have a setpoint that is not finite, yaw and yaw rate included, (n,)."""
    fields = setpoint.pos, setpoint.vel, setpoint.acc, setpoint.yaw, setpoint.yaw_rate
    return np.asarray(~np.isfinite(np.column_stack(fields)).all(axis=1))
