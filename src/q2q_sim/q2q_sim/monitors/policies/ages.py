"""Judge how old knowledge was when it was flown on, and how soon its loss was answered.

A command counts as computed from fresh knowledge where its status is OK or SATURATED; every other status,
and no command at all, is an action: the vehicle is flown as one that is not seen
(q2q_control.failsafe.ladder).
"""

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import CommandStatus
from q2q_sim.monitors.policies.blindness import misnamed, undated
from q2q_sim.monitors.policies.evidence import Evidence
from q2q_sim.monitors.policies.violations import Circumstances, Violation, worst

ROUNDING = 1e-6
"""Ages are differences of stamps [s]."""


def age(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return who was flown as usual on a state too old."""
    limit = circumstances.limits.fresh
    excess = np.where(_as_usual(evidence), evidence.state_age - limit - ROUNDING, np.nan)
    return worst("age", evidence, excess, (evidence.state_age, limit))


def action(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return who was flown as usual though no frame had shown it for longer than an action may take.

    Stamps are the only clock there is: frames of one that jumps cannot be dated, by nobody. Who is unseen
    after a jump is so since the stamps of the jump are over. Two that are taken for each other, as after a
    swap with which they were first seen, are seen as each other: who is missing cannot be said then.
    """
    limit = circumstances.limits.action
    if not evidence.seen.any():
        return []  # no motion capture in this recording
    t = evidence.t[:, None]
    seen = evidence.seen | undated(evidence, circumstances.faults)[:, None]
    last = np.maximum.accumulate(np.where(seen, t, t[:1]), axis=0)
    unseen = t - last
    told = _as_usual(evidence) & ~misnamed(evidence, circumstances.faults)
    excess = np.where(told, unseen - limit - ROUNDING, np.nan)
    return worst("action", evidence, excess, (unseen, limit))


def silence(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return the longest silence of a live controller, where it is longer than an action may take."""
    at = evidence.commanded_at
    if not evidence.live or len(at) < 2:
        return []
    gaps = np.diff(at)
    k = int(gaps.argmax())
    if gaps[k] <= circumstances.limits.action:
        return []
    return [Violation("silence", "the controller", float(at[k]), float(gaps[k]), circumstances.limits.action)]


def _as_usual(evidence: Evidence) -> NDArray[np.bool_]:
    return np.asarray(evidence.command_status <= CommandStatus.SATURATED)
