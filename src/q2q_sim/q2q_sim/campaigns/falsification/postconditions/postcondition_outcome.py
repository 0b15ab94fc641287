"""Outcome of one postcondition of a run, and the vehicles that faults of some kinds affect."""

import math
from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Mask, Names
from q2q_sim.faults.affected_vehicles import affected_vehicles
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies import Violation


class PostconditionOutcome(NamedTuple):
    """Outcome of one postcondition of a run."""

    violations: tuple[Violation, ...] = ()
    margin: float = math.inf
    """Minimum distance from the limit, as a part of it; infinite where nothing was judged [-]."""


def affected_by_kinds(names: Names, faults: tuple[Fault, ...], kinds: tuple[str, ...]) -> Mask:
    """Return which vehicles a fault of these kinds affects at some time, (n,)."""
    affected = np.zeros(len(names), dtype=np.bool_)
    for fault in faults:
        if fault.kind in kinds:
            affected |= affected_vehicles(fault, names)
    return affected
