"""Compensate the downwash on stock firmware: hand out setpoints whose acceleration already takes it off.

Crazyswarm2's FullState goes to the firmware's Mellinger controller, whose thrust is
m (acc + K_p e + K_d e' + g e_z): so the paper's compensation, -eta in U1 and in (24)-(25), is exactly

    acc = r''_ref - eta
"""

from dataclasses import replace

import numpy as np

from q2q_model.signals.values import Interference, SwarmSetpoint, index_of


def compensated_setpoint(setpoint: SwarmSetpoint, interference: Interference | None) -> SwarmSetpoint:
    """Return the setpoint with the predicted downwash taken off its acceleration, row by name.

    A vehicle whose downwash is not predicted, or is not a number, keeps its acceleration.
    """
    if interference is None or not interference.names:
        return setpoint
    rows = index_of(setpoint.names, interference.names)
    eta = np.where((rows >= 0)[:, None], interference.acc[rows], 0.0)
    return replace(setpoint, acc=setpoint.acc - np.where(np.isfinite(eta), eta, 0.0))
