"""Curves of a Plan message."""

import numpy as np
from q2q_msgs.msg import Plan

from q2q_control.inputs.plan_samples import Curve
from q2q_model.signals.cdr import BadMessageError

AXES = 4
"""x, y, z, yaw."""


def curves_of(message: Plan) -> list[Curve]:
    """Return the curve of each vehicle; raise BadMessageError if the array lengths disagree."""
    total = sum(message.pieces)
    wanted = total * AXES * message.order
    if len(message.pieces) != len(message.names) or len(message.durations) != total:
        raise BadMessageError(f"plan of {len(message.names)} vehicles: pieces and durations do not fit")
    if len(message.coefficients) != wanted:
        raise BadMessageError(f"plan has {len(message.coefficients)} coefficients; its pieces need {wanted}")
    rows = np.array(message.coefficients).reshape(total, AXES, message.order)
    ends = np.cumsum(message.pieces)[:-1]
    durations = np.split(np.array(message.durations), ends)
    return [Curve(*one) for one in zip(durations, np.split(rows, ends), strict=True)]
