"""Vehicles whose sensors have a steady error, which no filter can detect."""

import numpy as np

from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, Mask
from q2q_sim.faults.affected_vehicles import affected_vehicles
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace

UNDETECTABLE = ("jump", "swap", "clock_jump")
"""Steady sensor errors that no filter can detect: a displaced marker looks like a displaced vehicle."""
RECOVERY_S = 1.0
"""Longest time after a steady error until the true track is accepted again [s]."""


def with_sensor_error(trace: FlightTrace, faults: tuple[Fault, ...], after: float) -> Mask:
    """Return which vehicles have a steady sensor error, or had less than `after` [s] before, (T, n).

    A displaced marker is believed until its vehicle is measured again. Clock jumps may add up: their stamps
    are other ticks' by the sum of their sizes at most.
    """
    jumps = sum(abs(fault.size) for fault in faults if fault.kind == "clock_jump")
    mask = np.zeros((len(trace.t), len(trace.names)), dtype=np.bool_)
    for fault in faults:
        if fault.kind in UNDETECTABLE:
            shift = jumps if fault.kind == "clock_jump" else 0.0
            end = fault.start + fault.duration
            ends = _believed_until(trace, end) if fault.kind == "jump" else end + shift
            begun = trace.t >= fault.window(TICK_S)[0] - shift
            lasting = begun[:, None] & (trace.t[:, None] <= ends + after)
            mask |= lasting & affected_vehicles(fault, trace.names)
    return mask


def _believed_until(trace: FlightTrace, end: float) -> Array:
    """Return the last tick before each vehicle's first measurement after `end` [s], at least `end`, (n,)."""
    waiting = np.logical_and.accumulate(~trace.seen | (trace.t <= end)[:, None], axis=0)
    return np.asarray(np.where(waiting, trace.t[:, None], end).max(axis=0, initial=end))


def marker_displacement(trace: FlightTrace, faults: tuple[Fault, ...]) -> Array:
    """Return the displacement of each vehicle's markers, now or recently [m], (T, n)."""
    moved = np.zeros((len(trace.t), len(trace.names)))
    for fault in faults:
        if fault.kind == "jump":
            moved += abs(fault.size) * with_sensor_error(trace, (fault,), RECOVERY_S)
    return moved


def with_doubtful_stamps(trace: FlightTrace, faults: tuple[Fault, ...]) -> Mask:
    """Return the ticks whose stamps a clock jump may have given to frames of other times, (T,)."""
    jumps = tuple(fault for fault in faults if fault.kind == "clock_jump")
    return np.asarray(with_sensor_error(trace, jumps, 0.0).any(axis=1))


def after_label_swap(trace: FlightTrace, faults: tuple[Fault, ...]) -> Mask:
    """Return which vehicles may be mistaken for each other after a recent swap, (T, n)."""
    return with_sensor_error(trace, tuple(fault for fault in faults if fault.kind == "swap"), RECOVERY_S)
