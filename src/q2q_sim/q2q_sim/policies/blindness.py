"""Say which vehicles are flown blind: by commands that no state was used for."""

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals import CommandStatus
from q2q_sim.policies.evidence import Evidence

BLIND = (CommandStatus.HOLD, CommandStatus.LEVEL, CommandStatus.LAND, CommandStatus.CUT)

Mask = NDArray[np.bool_]


def blind(evidence: Evidence) -> Mask:
    """Return who is flown blind at each tick, (T, n)."""
    return np.asarray(np.isin(evidence.command_status, BLIND))


def blind_lately(evidence: Evidence, settle: float) -> Mask:
    """Return who is flown blind at each tick, or was less than `settle` [s] before, (T, n)."""
    t = evidence.t[:, None]
    last = np.maximum.accumulate(np.where(blind(evidence), t, -np.inf), axis=0)
    return np.asarray(t - last < settle)
