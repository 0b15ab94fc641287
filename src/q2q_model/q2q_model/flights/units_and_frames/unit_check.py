"""Refusal of flights whose positions or references are not in metres, as of motion capture in millimetres."""

import numpy as np

from q2q_model.estimation.association.outlier_thresholds import OutlierThresholds
from q2q_model.flights.flight import Flight
from q2q_model.signals.values import Array, Names


def check_flight_metres(flight: Flight) -> None:
    """Raise ValueError if positions (filtered ones, else motion capture) or references are not in metres."""
    known = np.where(np.isfinite(flight.pos).all(axis=-1, keepdims=True), flight.pos, flight.mocap_pos)
    check_metres(tuple(f"{name} in {flight.name}" for name in flight.names), known)
    check_metres(tuple(f"the reference of {name} in {flight.name}" for name in flight.names), flight.ref_pos)


def check_metres(names: Names, pos: Array) -> None:
    """Raise ValueError if most positions of a vehicle, (T, n, 3), lie beyond the largest that is accepted."""
    pos_max = OutlierThresholds().pos_max
    for row, name in enumerate(names):
        finite = pos[np.isfinite(pos[:, row]).all(axis=1), row]
        reach = np.abs(finite).max(axis=1)
        if reach.size and np.median(reach) > pos_max:
            raise ValueError(
                f"x, y, z of {name} reach {np.median(reach):g} m in the median (maximum {pos_max:g} m): "
                "check that they are in metres; a column map scales those of a table (bag_import --columns)"
            )
