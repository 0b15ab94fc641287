"""Extent of a plan of the high-level commander: the lowest and highest x, y, z that it leads through."""

import numpy as np

from q2q_model.signals.values import Three
from q2q_sim.firmware.commander.piecewise import Piecewise

SAMPLES = 16
"""Samples of a piece, next to its end: half a circle of radius 1 m is found to within 5 mm."""


@np.errstate(all="ignore")
def plan_extent(plan: Piecewise) -> tuple[Three, Three]:
    """Return the lowest and the highest x, y, z of a plan's goals [m], world; NaN where not finite."""
    times = plan.begin + np.linspace(0.0, max(plan.duration, 0.0), SAMPLES * len(plan.pieces) + 1)
    pos = np.array([plan.goal(t).pos for t in times.tolist()])  # (samples, 3)
    (low_x, low_y, low_z), (x, y, z) = pos.min(axis=0).tolist(), pos.max(axis=0).tolist()
    return (low_x, low_y, low_z), (x, y, z)
