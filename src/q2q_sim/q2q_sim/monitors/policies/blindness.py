"""Say which vehicles are flown blind, by commands that no state was used for, and whose sensors lie."""

import numpy as np
from numpy.typing import NDArray

from q2q_model.signals.values import Array, CommandStatus
from q2q_sim.faults.faults import KINDS, Fault
from q2q_sim.monitors.policies.evidence import Evidence

BLIND = (CommandStatus.HOLD, CommandStatus.LEVEL, CommandStatus.LAND, CommandStatus.CUT)
DOWN = (CommandStatus.LAND, CommandStatus.CUT)
"""Commands that send a vehicle to the floor, whatever its setpoint says."""
LYING = ("jump", "swap", "clock_jump")
"""Faults in which sensors lie so steadily that no filter can know: a marker moved is a vehicle moved."""
BELIEVED_S = 1.0
"""How long a steady lie may be believed after it ended [s]: until the true track is believed again."""

Mask = NDArray[np.bool_]


def blind(evidence: Evidence) -> Mask:
    """Return who is flown blind at each tick, (T, n)."""
    return np.asarray(np.isin(evidence.command_status, BLIND))


def blind_lately(evidence: Evidence, settle: float) -> Mask:
    """Return who is flown blind at each tick, or was less than `settle` [s] before, (T, n)."""
    return _lately(evidence, blind(evidence), settle)


def sent_down_lately(evidence: Evidence, settle: float) -> Mask:
    """Return who is sent to the floor at each tick, or was less than `settle` [s] before, (T, n)."""
    return _lately(evidence, np.asarray(np.isin(evidence.command_status, DOWN)), settle)


def lied_to(evidence: Evidence, faults: tuple[Fault, ...], after: float) -> Mask:
    """Return whose sensors lie steadily at each tick, or did less than `after` [s] before, (T, n)."""
    lied = np.zeros((len(evidence.t), len(evidence.names)), dtype=np.bool_)
    for fault in faults:
        if fault.kind in LYING:
            early = abs(fault.size) if fault.kind == "clock_jump" else 0.0
            end = fault.start + fault.duration
            times = (evidence.t >= fault.start - early) & (evidence.t <= end + early + after)
            lied |= times[:, None] & _struck(evidence, fault)
    return lied


def misplaced(evidence: Evidence, faults: tuple[Fault, ...]) -> Array:
    """Return by how much the markers of vehicles are moved, or were until lately [m], (T, n)."""
    moved = np.zeros((len(evidence.t), len(evidence.names)))
    for fault in faults:
        if fault.kind == "jump":
            moved += abs(fault.size) * lied_to(evidence, (fault,), BELIEVED_S)
    return moved


def undated(evidence: Evidence, faults: tuple[Fault, ...]) -> Mask:
    """Return the ticks whose stamps a jumping clock may have given to frames of other times, (T,)."""
    jumps = tuple(fault for fault in faults if fault.kind == "clock_jump")
    return np.asarray(lied_to(evidence, jumps, 0.0).any(axis=1))


def misnamed(evidence: Evidence, faults: tuple[Fault, ...]) -> Mask:
    """Return who may be taken for another, as its marker was under the other's name lately, (T, n)."""
    return lied_to(evidence, tuple(fault for fault in faults if fault.kind == "swap"), BELIEVED_S)


def _lately(evidence: Evidence, when: Mask, settle: float) -> Mask:
    t = evidence.t[:, None]
    last = np.maximum.accumulate(np.where(when, t, -np.inf), axis=0)
    return np.asarray(t - last < settle)


def _struck(evidence: Evidence, fault: Fault) -> Mask:
    if KINDS[fault.kind].whole or not fault.vehicles:
        return np.ones(len(evidence.names), dtype=np.bool_)
    return np.isin(evidence.names, fault.vehicles)
