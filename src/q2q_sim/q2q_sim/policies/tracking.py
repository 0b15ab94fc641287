"""Judge where vehicles are: in the room, where their state says, and back on their way after trouble."""

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals import CommandStatus, TrackStatus
from q2q_sim.faults import KINDS, Fault
from q2q_sim.policies.blindness import blind
from q2q_sim.policies.evidence import Evidence
from q2q_sim.policies.verdicts import Circumstances, Violation, worst

LYING = ("jump", "swap", "clock_jump")
"""Faults in which sensors lie so steadily that no filter can know: a marker moved is a vehicle moved."""
BELIEVED_S = 1.0
"""How long a steady lie may be believed after it ended [s]: until the true track is believed again."""
Mask = NDArray[np.bool_]


def room(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return who flew away from where it was sent."""
    off = np.linalg.norm(evidence.true_pos - evidence.sent_pos, axis=2)  # (T, n)
    limit = circumstances.limits.stray_room
    return worst("room", evidence, off - limit, (off, limit))


def belief(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return whose state was said to be tracked and was false."""
    off = np.linalg.norm(evidence.state_pos - evidence.true_pos, axis=2)
    trusted = (evidence.state_status == TrackStatus.TRACKED) & ~lied_to(evidence, circumstances.faults)
    limit = circumstances.limits.belief
    return worst("belief", evidence, np.where(trusted, off - limit, np.nan), (off, limit))


def come_back(evidence: Evidence, circumstances: Circumstances) -> list[Violation]:
    """Return who was not back on its way once the last trouble was long enough ago."""
    limits = circumstances.limits
    calm = evidence.t > last_trouble(evidence, circumstances.faults) + limits.settle
    cut = (evidence.command_status == CommandStatus.CUT).any(axis=0)  # they are on the ground, and stay there
    off = np.linalg.norm(evidence.true_pos - evidence.sent_pos, axis=2)
    excess = np.where(calm[:, None] & ~cut, off - limits.back, np.nan)
    return worst("return", evidence, excess, (off, limits.back))


def last_trouble(evidence: Evidence, faults: tuple[Fault, ...]) -> float:
    """Return when anything was last wrong [s]: a fault, or a command not computed; -inf for never."""
    wrong = blind(evidence).any(axis=1)
    noted = [float(evidence.t[wrong][-1])] if wrong.any() else []
    return max([*noted, *(_end(fault) for fault in faults)], default=-np.inf)


def lied_to(evidence: Evidence, faults: tuple[Fault, ...]) -> Mask:
    """Return whose sensors lie steadily at each tick, (T, n)."""
    lied = np.zeros((len(evidence.t), len(evidence.names)), dtype=np.bool_)
    for fault in faults:
        if fault.kind in LYING:
            early = abs(fault.size) if fault.kind == "clock_jump" else 0.0
            times = (evidence.t >= fault.start - early) & (evidence.t <= _end(fault) + early + BELIEVED_S)
            lied |= times[:, None] & _struck(evidence, fault)
    return lied


def _end(fault: Fault) -> float:
    return fault.start + fault.duration


def _struck(evidence: Evidence, fault: Fault) -> Mask:
    if KINDS[fault.kind].whole or not fault.vehicles:
        return np.ones(len(evidence.names), dtype=np.bool_)
    return np.isin(evidence.names, fault.vehicles)
