"""Air `recorded`: that of the shipped room, with the residuals of real flights in place of its process.

    n = (y + |eta|) / sqrt(s^2 + c^2),   s = floor + slope |eta|

on exposed rows inside a wake, |eta| > e_0, with the mean by the room's jet and absorption, and c^2, the
variance of the vehicle's clear air. Every stretch without a gap is a piece; pieces fade into each other, and
the whole is brought to mean 0 and variance 1.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from q2q_model.flights.tables.table_file import TABLES
from q2q_model.recordings.flight_recording import Recording
from q2q_model.recordings.recording_reader import flights_among, recording_of_bag, recording_of_table
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.air_file import load
from q2q_sim.air.air_names import ROOM, AirError, air_path, recorded_paths
from q2q_sim.air.air_terms import INSIDE, SHORTEST, ResidualTerm
from q2q_sim.air.learning.records.air_record import AirRecord, air_records
from q2q_sim.air.learning.residual.wake_residuals import WakeResiduals, wake_residuals
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.unit_processes import FADE_S, RECORDED_HZ, cross_fade

FADE = round(FADE_S * RECORDED_HZ)
"""Samples in which two pieces overlap."""


@lru_cache(maxsize=4)
def recorded_air(name: str) -> RoomAir:
    """Return the air `recorded`, or `recorded:PATH` with the residuals of a flight or a folder of them.

    Raises:
        AirError: there is no such flight, one cannot be read, or too few rows lie under another vehicle.
    """
    room = load(air_path(ROOM))
    try:
        recordings = [_recording(path) for path in flights_among(recorded_paths(name, room.flights))[0]]
    except ValueError as error:
        raise AirError(f"air {name}: {error}") from error
    lag = room.vehicle.thrust_lag_s if room.vehicle else CRAZYFLIE_2_0.thrust_lag
    records, _ = air_records(recordings, CRAZYFLIE_2_0, lag)
    played = recorded_residual(records, room)
    if len(played) < SHORTEST:
        raise AirError(
            f"air {name}: {len(played)} samples of its flights lie under another vehicle; must be at least "
            f"{SHORTEST}: give more flights"
        )
    return replace(room, residual=replace(_process(room), recording=played))


def recorded_residual(records: Sequence[AirRecord], room: RoomAir) -> Array:
    """Return n of flights at RECORDED_HZ, (k,); empty if no vehicle is long enough under another."""
    if room.jet is None:
        raise AirError(f"air {ROOM} has no jet, so flights show no residual of it")
    process = _process(room)
    pieces = [
        piece
        for wake in wake_residuals(records, room.jet, room.absorption)
        for piece in _pieces(wake, process)
        if len(piece) >= 2 * FADE
    ]
    if not pieces:
        return np.empty(0)
    series = pieces[0]
    for piece in pieces[1:]:
        over = cross_fade(series[-FADE:, None], piece[:FADE, None])[:, 0]
        series = np.concatenate([series[:-FADE], over, piece[FADE:]])
    return np.asarray((series - series.mean()) / series.std())


def _process(room: RoomAir) -> ResidualTerm:
    if room.residual is None:
        raise AirError(f"air {ROOM} has no residual to give the size of recorded ones")
    return room.residual


def _pieces(wake: WakeResiduals, process: ResidualTerm) -> list[Array]:
    """Return n on every stretch of exposed rows without a hole of FADE_S, sampled at RECORDED_HZ."""
    size = process.floor_mps2 + process.slope * wake.eta
    n = wake.residual / np.sqrt(size**2 + wake.clear[0])
    rows, t = np.flatnonzero(wake.one.exposed & (wake.eta > INSIDE)), wake.record.motion.t
    ends = (np.diff(rows) > 1) | (np.diff(t[rows]) > FADE_S)
    stretches = np.split(rows, np.flatnonzero(ends) + 1)
    return [
        np.interp(np.arange(t[k[0]], t[k[-1]], 1.0 / RECORDED_HZ), t[k], n[k]) for k in stretches if k.size
    ]


def _recording(path: Path) -> Recording:
    return recording_of_table(path) if path.suffix in TABLES else recording_of_bag(path)
