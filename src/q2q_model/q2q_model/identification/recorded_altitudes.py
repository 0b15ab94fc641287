"""Altitude records of recordings, with the downwash compensation that their logs have."""

from dataclasses import replace

import numpy as np

from q2q_model.flights.flight_log import FlightLog, log_at
from q2q_model.identification.gains.altitude_from_flight import altitude_records
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.recordings.flight_recording import Recording
from q2q_model.vehicle.constants import Vehicle

FEED_FORWARD = "fa_ff"
"""Log column of the downwash force that the controller compensated [N]."""


def recorded_altitudes(
    one: Recording, vehicle: Vehicle
) -> tuple[tuple[AltitudeRecord, ...], tuple[str, ...]]:
    """Return a flight's records, with the feed-forward of its log if that has one, and remarks."""
    records, holes = altitude_records(one.flight, vehicle)
    return tuple(_with_feed_forward(record, one.log, vehicle) for record in records), tuple(holes)


def _with_feed_forward(record: AltitudeRecord, log: FlightLog | None, vehicle: Vehicle) -> AltitudeRecord:
    if log is None or FEED_FORWARD not in log.columns:
        return record
    logged = np.flatnonzero(np.isfinite(log.values).any(axis=(1, 2)))
    if not logged.size:
        return record
    at = np.searchsorted(log.t[logged], record.t - 0.5 * record.dt)
    rows = logged[np.clip(at, 0, logged.size - 1)]
    column = log_at(log, log.t, record.names).column(FEED_FORWARD)
    return replace(record, feed_forward=column[rows] / vehicle.mass)
