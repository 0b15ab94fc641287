"""Policy on falls: no vehicle with a setpoint above the floor touches it."""

import numpy as np

from q2q_model.signals.values import Mask
from q2q_sim.monitors.policies.exemptions.feedback_loss import sent_down_lately
from q2q_sim.monitors.policies.exemptions.unforeseen import helpless_lately
from q2q_sim.monitors.policies.flight_trace import FlightTrace
from q2q_sim.monitors.policies.violations import Circumstances, Limits, Violation


def floor(trace: FlightTrace, circumstances: Circumstances) -> list[Violation]:
    """Return the first floor contact of each vehicle that was not commanded to land or cut.

    Take-off and landing are not falls: there the setpoint itself is near the floor. Nor is it a fall that a
    command could prevent if no command carries the vehicle (overpowered), or none is known to (unforeseen).
    """
    limits = circumstances.limits
    excused = sent_down_lately(trace, limits.settle) | helpless_lately(trace, circumstances)
    fallen = touches_floor(trace, limits) & ~excused
    return [
        Violation("floor", name, float(trace.t[k]), float(trace.true_pos[k, row, 2]), limits.floor)
        for row, name in enumerate(trace.names)
        for k in np.flatnonzero(fallen[:, row])[:1]
    ]


def touches_floor(trace: FlightTrace, limits: Limits) -> Mask:
    """Return which vehicles are on the floor though their setpoints are above it, (T, n)."""
    on_floor = trace.true_pos[..., 2] <= limits.floor
    sent_above = trace.sent_pos[..., 2] > limits.take_off
    return np.asarray(on_floor & sent_above)
