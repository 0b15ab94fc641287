"""Notes on flights that seem to be recorded in another frame, for tools that go on with them."""

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.flights.units_and_frames.up_axis import y_up_reason
from q2q_model.flights.units_and_frames.upright_check import tilt_reason


def frame_notes(flight: Flight) -> list[str]:
    """Return why z seems not to be up or an attitude to be wrong, except in flights of a simulator."""
    if np.isfinite(flight.true_pos).any():
        return []
    pos = np.where(np.isfinite(flight.mocap_pos), flight.mocap_pos, flight.pos)
    reasons = (y_up_reason(pos), tilt_reason(flight))
    return [f"flight {flight.name}: {reason}" for reason in reasons if reason]
