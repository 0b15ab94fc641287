"""Vehicles whose thrust is exceeded: pushed down by more than the largest one, or too weak to come back.

    m (g - eta_z) > k U1_max                      k: share of the thrust that battery and rotors still give
    m (g + 2 v / settle) > k U1_max,  k < 1       found as it sinks at v = TOUCHDOWN_MAX, it has half of
                                                  `settle` to stop

Battery sags and weak rotors are known only where faults are injected. A rotor that gives less costs its share
of the four. Where the downwash is unknown, no vehicle is pushed.
"""

import numpy as np

from q2q_control.failsafe.tracking_loss.braking_law import TOUCHDOWN_MAX
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.faults.affected_vehicles import affected_vehicles
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies.inputs.circumstances import Circumstances
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace

ROTORS = 4


def thrust_exceeded(trace: FlightTrace, circumstances: Circumstances) -> Mask:
    """Return which vehicles have too little thrust at each tick, (T, n)."""
    vehicle, left = circumstances.vehicle, thrust_left(trace, circumstances.faults)
    most = left * vehicle.rpyt_thrust_max / vehicle.mass
    pushed = GRAVITY - trace.true_downwash[..., 2] > most
    needed = GRAVITY + 2.0 * TOUCHDOWN_MAX / circumstances.limits.settle
    return np.asarray(pushed | (left < 1.0) & (needed > most))


def thrust_left(trace: FlightTrace, faults: tuple[Fault, ...]) -> Array:
    """Return the share of the thrust that battery sags and weak rotors leave, from 0 to 1, (T, n)."""
    left: Array = np.ones((len(trace.t), len(trace.names)))
    for fault in faults:
        left *= 1.0 - _lost(fault, trace.t[:, None]) * affected_vehicles(fault, trace.names)
    return left


def _lost(fault: Fault, t: Array) -> Array:
    """Return the share of the thrust that a fault takes at times [s], (T, 1)."""
    if fault.kind == "battery_sag":
        since = t - fault.start
        return np.asarray(fault.size * np.clip(since / max(fault.duration, TICK_S), 0.0, 1.0))
    if fault.kind == "weak_rotor":
        begin, end = fault.window(TICK_S)
        return np.asarray(fault.size / ROTORS * ((t >= begin) & (t < end)))
    return np.zeros_like(t)
