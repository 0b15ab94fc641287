"""Vehicles flown without feedback (blind), and vehicles whose sensors have a steady error."""

import numpy as np

from q2q_control.failsafe.evasion.descent_evasion import FARTHEST, REACH
from q2q_model.signals.values import Array, CommandStatus, Mask
from q2q_sim.faults.faults import KINDS, Fault
from q2q_sim.monitors.policies.evidence import Evidence

BLIND = (CommandStatus.HOLD, CommandStatus.LEVEL, CommandStatus.LAND, CommandStatus.CUT)
DOWN = (CommandStatus.LAND, CommandStatus.CUT)
"""Commands that send a vehicle to the floor, whatever its setpoint."""
EVADED = (CommandStatus.LEVEL, CommandStatus.LAND)
"""Commands of vehicles that others evade."""
UNDETECTABLE = ("jump", "swap", "clock_jump")
"""Steady sensor errors that no filter can detect: a displaced marker looks like a displaced vehicle."""
EARLY_S = 0.005
"""A fault acts from up to half a tick before its start on (Fault.acts_at) [s]."""
DRIFT_M = 0.4
"""How far a vehicle flown blind may be from where its controller believes it [m] (descent_evasion)."""
RECOVERY_S = 1.0
"""Longest time after a steady error until the true track is accepted again [s]."""


def blind(evidence: Evidence) -> Mask:
    """Return which vehicles are flown blind at each tick, (T, n)."""
    return np.asarray(np.isin(evidence.command_status, BLIND))


def blind_lately(evidence: Evidence, settle: float) -> Mask:
    """Return which vehicles are flown blind at each tick, or were less than `settle` [s] before, (T, n)."""
    return within_settle_time(evidence, blind(evidence), settle)


def sent_down_lately(evidence: Evidence, settle: float) -> Mask:
    """Return which vehicles are sent to the floor, or were less than `settle` [s] before, (T, n)."""
    return within_settle_time(evidence, np.asarray(np.isin(evidence.command_status, DOWN)), settle)


def evading_lately(evidence: Evidence, settle: float) -> Mask:
    """Return which vehicles may evade one flown blind, or might less than `settle` [s] before, (T, n).

    They or where they are sent are near it, at whichever height; it counts, too. The controller shifts their
    setpoints (q2q_control.failsafe.evasion.descent_evasion), which the flight records before the shift.
    """
    pos, gone = evidence.true_pos, np.isin(evidence.command_status, EVADED)
    evading = np.zeros(gone.shape, dtype=np.bool_)
    for places in (pos, evidence.sent_pos):
        for j in np.flatnonzero(gone.any(axis=0)):
            evading |= _near(places, pos[:, j], FARTHEST) & gone[:, j, None]
    return within_settle_time(evidence, evading, settle)


def beneath(places: Array, pos: Array, some: Mask) -> Mask:
    """Return which `places` [m] (T, n, 3) are below `some` (T, m) of the vehicles at pos (T, m, 3), (T, n).

    Nearer to them than vehicles evade one flown blind, and that may have drifted.
    """
    below = np.zeros(places.shape[:2], dtype=np.bool_)
    for j in np.flatnonzero(some.any(axis=0)):
        lower = pos[:, j, None, 2] > places[..., 2]
        below |= lower & _near(places, pos[:, j], REACH) & some[:, j, None]
    return below


def _near(places: Array, pos: Array, reach: float) -> Mask:
    """Return which places [m] (T, n, 3) are within `reach` [m] of a vehicle that drifted, (T, n)."""
    offset = pos[:, None, :2] - places[..., :2]
    return np.asarray(np.hypot(offset[..., 0], offset[..., 1]) < reach + DRIFT_M)


def with_sensor_error(evidence: Evidence, faults: tuple[Fault, ...], after: float) -> Mask:
    """Return which vehicles have a steady sensor error, or had less than `after` [s] before, (T, n).

    A displaced marker is believed until its vehicle is measured again. Clock jumps may add up: their stamps
    are other ticks' by the sum of their sizes at most.
    """
    jumps = sum(abs(fault.size) for fault in faults if fault.kind == "clock_jump")
    mask = np.zeros((len(evidence.t), len(evidence.names)), dtype=np.bool_)
    for fault in faults:
        if fault.kind in UNDETECTABLE:
            shift = jumps if fault.kind == "clock_jump" else 0.0
            end = fault.start + fault.duration
            ends = _believed_until(evidence, end) if fault.kind == "jump" else end + shift
            begun = evidence.t > fault.start - shift - EARLY_S
            mask |= begun[:, None] & (evidence.t[:, None] <= ends + after) & struck_vehicles(evidence, fault)
    return mask


def _believed_until(evidence: Evidence, end: float) -> Array:
    """Return the last tick before each vehicle's first measurement after `end` [s], at least `end`, (n,)."""
    waiting = np.logical_and.accumulate(~evidence.seen | (evidence.t <= end)[:, None], axis=0)
    return np.asarray(np.where(waiting, evidence.t[:, None], end).max(axis=0, initial=end))


def marker_displacement(evidence: Evidence, faults: tuple[Fault, ...]) -> Array:
    """Return the displacement of each vehicle's markers, now or recently [m], (T, n)."""
    moved = np.zeros((len(evidence.t), len(evidence.names)))
    for fault in faults:
        if fault.kind == "jump":
            moved += abs(fault.size) * with_sensor_error(evidence, (fault,), RECOVERY_S)
    return moved


def with_doubtful_stamps(evidence: Evidence, faults: tuple[Fault, ...]) -> Mask:
    """Return the ticks whose stamps a clock jump may have given to frames of other times, (T,)."""
    jumps = tuple(fault for fault in faults if fault.kind == "clock_jump")
    return np.asarray(with_sensor_error(evidence, jumps, 0.0).any(axis=1))


def after_label_swap(evidence: Evidence, faults: tuple[Fault, ...]) -> Mask:
    """Return which vehicles may be mistaken for each other after a recent swap, (T, n)."""
    return with_sensor_error(evidence, tuple(fault for fault in faults if fault.kind == "swap"), RECOVERY_S)


def within_settle_time(evidence: Evidence, when: Mask, settle: float) -> Mask:
    """Return which vehicles are in a condition, or were less than `settle` [s] before, (T, n)."""
    t = evidence.t[:, None]
    last = np.maximum.accumulate(np.where(when, t, -np.inf), axis=0)
    return np.asarray(t - last < settle)


def runs_of_true(mask: Mask) -> list[tuple[int, int]]:
    """Return begin and end of each run of True in (T,)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def struck_vehicles(evidence: Evidence, fault: Fault) -> Mask:
    """Return which vehicles a fault strikes, (n,)."""
    if KINDS[fault.kind].whole or not fault.vehicles:
        return np.ones(len(evidence.names), dtype=np.bool_)
    return np.isin(evidence.names, fault.vehicles)
