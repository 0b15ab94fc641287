"""Vehicles of a flight on which a fault acts."""

import numpy as np

from q2q_model.signals.values import Mask, Names
from q2q_sim.faults.faults import Fault


def affected_vehicles(fault: Fault, names: Names) -> Mask:
    """Return which of the vehicles `names` a fault affects, (n,); one that names none affects all."""
    return np.array([not fault.vehicles or name in fault.vehicles for name in names], dtype=np.bool_)
