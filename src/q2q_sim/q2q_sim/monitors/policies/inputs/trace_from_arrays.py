"""Trace from the arrays of a `Flight`."""

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_sim.monitors.metrics.flight_metrics import best_position
from q2q_sim.monitors.policies.inputs.flight_trace import FlightTrace


def trace_from_arrays(flight: Flight) -> FlightTrace:
    """Return the trace in a flight's arrays.

    Positions are the true ones, else the filtered ones. A flight has neither recording times nor ages of
    states, so the policies state_age, state_error and silence do not apply.
    """
    unknown = np.full(flight.thrust.shape, np.nan)
    replanned, planned = np.isfinite(flight.safe_pos), np.isfinite(flight.ref_pos)
    return FlightTrace(
        t=flight.t,
        names=flight.names,
        true_pos=best_position(flight),
        sent_pos=np.where(replanned, flight.safe_pos, flight.ref_pos),
        asked_pos=np.where(planned, flight.ref_pos, flight.safe_pos),
        seen=np.asarray(np.isfinite(flight.mocap_pos).all(axis=2)),
        state_pos=flight.pos,
        state_age=unknown,
        state_status=unknown,
        thrust=flight.thrust,
        roll=flight.roll,
        pitch=flight.pitch,
        command_status=flight.command_status,
        recorded_at=flight.t,
        commanded_at={},
        live=False,
        not_finite=(),
        true_downwash=flight.true_eta,
    )
