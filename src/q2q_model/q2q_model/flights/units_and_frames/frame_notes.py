"""Notes on flights that seem to be recorded in another frame, for tools that go on with them."""

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.flights.units_and_frames.tilt_direction import tilt_direction_reason
from q2q_model.flights.units_and_frames.up_axis import up_axis_reason
from q2q_model.flights.units_and_frames.upright_check import tilt_reason


def frame_notes(flight: Flight) -> list[str]:
    """Return why z seems not to be up or an attitude to be wrong, except in flights of a simulator."""
    return [*axis_notes(flight), *_noted(flight, tilt_reason(flight))]


def axis_notes(flight: Flight) -> list[str]:
    """Return why z seems not to be up or attitudes to lean the wrong way, except in flights of a simulator.

    For tools that refuse attitudes that are not upright.
    """
    pos = np.where(np.isfinite(flight.mocap_pos), flight.mocap_pos, flight.pos)
    quat = np.where(np.isfinite(flight.quat), flight.quat, flight.mocap_quat)
    leans = tilt_direction_reason(flight.t, flight.names, pos, quat)
    return [*_noted(flight, up_axis_reason(pos)), *_noted(flight, leans)]


def _noted(flight: Flight, reason: str) -> list[str]:
    """Return a reason with the flight's name; empty without one, and where the true frame is known."""
    return [f"flight {flight.name}: {reason}"] if reason and not np.isfinite(flight.true_pos).any() else []
