"""Policies on time: age of the states behind commands, time to the fallback, gaps between commands.

A command counts as computed from a fresh state if its status is OK or SATURATED; every other status, and a
missing command, counts as a fallback (q2q_control.failsafe.ladder).
"""

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import CommandStatus
from q2q_sim.monitors.policies.blindness import after_label_swap, with_doubtful_stamps
from q2q_sim.monitors.policies.evidence import Evidence
from q2q_sim.monitors.policies.violations import Circumstances, Violation, worst_violations

ROUNDING = 1e-6
"""Ages are differences of stamps [s]."""


def age(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles flown normally on too old a state."""
    limit = circumstances.limits.fresh
    excess = np.where(_as_usual(evidence), evidence.state_age - limit - ROUNDING, np.nan)
    return worst_violations("age", evidence, excess, (evidence.state_age, limit))


def action(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return the vehicles flown normally though not in any frame for longer than a fallback may take.

    Stamps are the only clock: frames with jumping stamps cannot be dated, so the time without observation
    starts anew after a clock jump. Vehicles whose names are exchanged are observed as each other: which of
    them is missing is unknown then.
    """
    limit = circumstances.limits.action
    if not evidence.seen.any():
        return []  # no motion capture in this recording
    t = evidence.t[:, None]
    seen = evidence.seen | with_doubtful_stamps(evidence, circumstances.faults)[:, None]
    last = np.maximum.accumulate(np.where(seen, t, t[:1]), axis=0)
    unseen = t - last
    reported = _as_usual(evidence) & ~after_label_swap(evidence, circumstances.faults)
    excess = np.where(reported, unseen - limit - ROUNDING, np.nan)
    return worst_violations("action", evidence, excess, (unseen, limit))


def silence(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return the longest gap between commands of a live controller, if longer than a fallback may take."""
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
