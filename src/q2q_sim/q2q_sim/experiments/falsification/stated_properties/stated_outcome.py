"""Outcome of one property of a run, and the vehicles that faults strike."""

import math
from typing import NamedTuple

from q2q_model.signals.values import Names
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies import Violation


class StatedOutcome(NamedTuple):
    """Outcome of one property of a run."""

    violations: tuple[Violation, ...] = ()
    margin: float = math.inf
    """Least distance from the limit, as a part of it; infinite where nothing was judged [-]."""


def struck_by_kinds(names: Names, faults: tuple[Fault, ...], kinds: tuple[str, ...]) -> list[bool]:
    """Return which vehicles a fault of these kinds strikes at some time."""
    some = [fault for fault in faults if fault.kind in kinds]
    return [any(not fault.vehicles or name in fault.vehicles for fault in some) for name in names]
