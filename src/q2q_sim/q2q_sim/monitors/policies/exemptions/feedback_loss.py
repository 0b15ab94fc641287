"""Vehicles flown without feedback, by a fallback command, and vehicles that may evade them."""

import numpy as np

from q2q_control.failsafe.evasion.descent_evasion import FARTHEST, REACH
from q2q_model.flights.masks_over_time import last_time
from q2q_model.signals.values import Array, CommandStatus, Mask
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace

FALLBACKS = (CommandStatus.HOLD, CommandStatus.LEVEL, CommandStatus.LAND, CommandStatus.CUT)
"""Commands without feedback of the position."""
DOWN = (CommandStatus.LAND, CommandStatus.CUT)
"""Commands that send a vehicle to the floor, whatever its setpoint."""
EVADED = (CommandStatus.LEVEL, CommandStatus.LAND)
"""Commands of vehicles that others evade."""
DRIFT_M = 0.4
"""How far a vehicle without feedback may be from where its controller believes it [m] (descent_evasion)."""


def without_feedback(trace: FlightTrace) -> Mask:
    """Return which vehicles are flown without feedback at each tick, (T, n)."""
    return np.asarray(np.isin(trace.command_status, FALLBACKS))


def without_feedback_lately(trace: FlightTrace, settle: float) -> Mask:
    """Return which vehicles are flown without feedback, or were less than `settle` [s] before, (T, n)."""
    return within_settle_time(trace, without_feedback(trace), settle)


def sent_down_lately(trace: FlightTrace, settle: float) -> Mask:
    """Return which vehicles are sent to the floor, or were less than `settle` [s] before, (T, n)."""
    return within_settle_time(trace, np.asarray(np.isin(trace.command_status, DOWN)), settle)


def evading_lately(trace: FlightTrace, settle: float) -> Mask:
    """Return which vehicles may evade one without feedback, or might less than `settle` [s] before, (T, n).

    They or where they are sent are near it, at whichever height; it counts, too. The controller shifts their
    setpoints (q2q_control.failsafe.evasion.descent_evasion), which the flight records before the shift.
    """
    pos, gone = trace.true_pos, np.isin(trace.command_status, EVADED)
    evading = np.zeros(gone.shape, dtype=np.bool_)
    for places in (pos, trace.sent_pos):
        for j in np.flatnonzero(gone.any(axis=0)):
            evading |= _near(places, pos[:, j], FARTHEST) & gone[:, j, None]
    return within_settle_time(trace, evading, settle)


def beneath(places: Array, pos: Array, some: Mask) -> Mask:
    """Return which `places` [m] (T, n, 3) are below `some` (T, m) of the vehicles at pos (T, m, 3), (T, n).

    Nearer to them than vehicles evade one without feedback, and that may have drifted.
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


def within_settle_time(trace: FlightTrace, when: Mask, settle: float) -> Mask:
    """Return which vehicles are in a condition, or were less than `settle` [s] before, (T, n)."""
    return np.asarray(trace.t[:, None] - last_time(when, trace.t) < settle)
