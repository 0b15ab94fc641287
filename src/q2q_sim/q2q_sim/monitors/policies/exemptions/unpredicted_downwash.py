"""Vehicles without measurements in a downwash that nothing can report to their controller.

A vehicle without feedback knows of the push on it by prediction only. There is none if

    its controller ignores the downwash, and |eta| > PUSH
    it is below another, nearer than where it evades one, and the marker of either is displaced

Both are conditions under which no command is known to keep it: such runs are counted, and their vehicles
judged again `settle` later (exempt_lately), as those are whose thrust is exceeded.
"""

import numpy as np

from q2q_model.signals.values import Mask
from q2q_sim.monitors.policies.exemptions.feedback_loss import beneath, within_settle_time, without_feedback
from q2q_sim.monitors.policies.exemptions.sensor_errors import marker_displacement
from q2q_sim.monitors.policies.exemptions.thrust_exceeded import thrust_exceeded
from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace

PUSH = 0.1
"""Downwash that counts [m/s^2]: that at the edge of an identified zone, 5 cm after a second."""


def unpredicted_downwash(trace: FlightTrace, circumstances: Circumstances) -> Mask:
    """Return which vehicles without feedback nothing can predict the downwash of, at each tick, (T, n)."""
    unaided = without_feedback(trace)
    if not unaided.any():
        return unaided
    pos, displaced = trace.true_pos, marker_displacement(trace, circumstances.faults) > 0.0
    untold = beneath(pos, pos, displaced) | (displaced & beneath(pos, pos, np.ones_like(displaced)))
    if not circumstances.aware:
        untold |= np.linalg.norm(trace.true_downwash, axis=2) > PUSH
    return unaided & untold


def unpredicted_downwash_lately(trace: FlightTrace, circumstances: Circumstances) -> Mask:
    """Return which vehicles are in an unpredicted downwash, or were less than `settle` [s] before, (T, n)."""
    return _exempt_lately(trace, circumstances, unpredicted_downwash(trace, circumstances))


def exempt_lately(trace: FlightTrace, circumstances: Circumstances) -> Mask:
    """Return which vehicles are uncontrollable, or were less than `settle` [s] before, (T, n)."""
    uncontrollable = thrust_exceeded(trace, circumstances) | unpredicted_downwash(trace, circumstances)
    return _exempt_lately(trace, circumstances, uncontrollable)


def _exempt_lately(trace: FlightTrace, circumstances: Circumstances, uncontrollable: Mask) -> Mask:
    """Return where uncontrollable vehicles are exempt, (T, n): nowhere if the circumstances exempt none."""
    lately = within_settle_time(trace, uncontrollable, circumstances.limits.settle)
    return lately & circumstances.exempts_uncontrollable
