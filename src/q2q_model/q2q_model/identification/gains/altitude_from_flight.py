"""Altitude records of a recorded flight: one for each piece without a hole, of the vehicles that flew."""

import numpy as np

from q2q_model.flights.flight import Flight, flight_of_vehicles
from q2q_model.flights.interpolated_gaps import resample
from q2q_model.flights.outliers import find_outliers, repair
from q2q_model.flights.reference_remarks import reference_remarks
from q2q_model.flights.sampled_reference import SampledReference, flown_reference
from q2q_model.flights.units_and_frames.unit_check import check_flight_metres
from q2q_model.flights.units_and_frames.upright_check import body_z, check_upright
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.flown_pieces import (
    common_rows,
    finite_rows,
    pieces_between_holes,
    placed_rows,
    standing_vehicles,
)
from q2q_model.identification.gains.velocity_limit import is_differentiated
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import GRAVITY, Vehicle

STANDING = 0.25
"""Share of the weight below which a commanded thrust is that of a vehicle on the ground [-]: in recorded
flights, commands in the air are 0.64 or more."""


def altitude_records(flight: Flight, vehicle: Vehicle) -> tuple[list[AltitudeRecord], list[str]]:
    """Return the altitude records of a flight, from hole to hole, and remarks on holes and vehicles left out.

    Raises:
        ValueError: as `altitude_record`, or no 2 s between holes.
    """
    standing = standing_vehicles(flight)
    if len(standing) == len(flight.names):
        standing = []
    flown = flight_of_vehicles(flight, tuple(name for name in flight.names if name not in standing))
    pieces, holes = pieces_between_holes(flown)
    records, given = zip(*(_record_and_reference(piece, vehicle) for piece in pieces), strict=True)
    stood = [f"{flight.name}: {', '.join(standing)} never flew: left out of the gains"] if standing else []
    return list(records), [*stood, *holes, *reference_remarks(flown.name, flown.names, given)]


def altitude_record(flight: Flight, vehicle: Vehicle) -> AltitudeRecord:
    """Return the altitude record of a flight of identical vehicles; holes are interpolated.

    Filtered states, the input of the controller, are used where recorded; else motion capture with
    interpolated outliers (section 2.2) and its differences.

    Raises:
        ValueError: no reference, positions not in metres, less than 2 s of both, or an attitude that is not
            upright.
    """
    return _record_and_reference(flight, vehicle)[0]


def _record_and_reference(flight: Flight, vehicle: Vehicle) -> tuple[AltitudeRecord, SampledReference]:
    check_upright(flight)
    check_flight_metres(flight)
    mocap = np.where(np.isfinite(flight.mocap_pos), flight.mocap_pos, np.nan)
    visible, placed = finite_rows(mocap), placed_rows(flight)
    bad = find_outliers(flight.t, mocap)
    rows = common_rows(flight)
    given = flown_reference(flight)
    ref = np.stack([given.pos[..., 2], given.vel[..., 2], given.acc[..., 2]], axis=-1)
    repaired = repair(flight.t, mocap, bad)
    pos = np.where(np.isfinite(flight.pos), flight.pos, repaired)
    vel = np.where(np.isfinite(flight.vel), flight.vel, np.gradient(repaired, flight.t, axis=0))
    t = np.arange(flight.t[rows][0], flight.t[rows][-1] + 1e-9, dt := float(np.median(np.diff(flight.t))))
    axis, commanded_acc = body_z(flight), _commanded_acc(flight, vehicle, placed & given.sure)
    pos, vel, axis, ref = (resample(flight.t, values, t) for values in (pos, vel, axis, ref))
    nearest = np.clip(np.searchsorted(flight.t, t - 0.5 * dt), 0, flight.t.size - 1)
    record = AltitudeRecord(
        name=flight.name,
        names=flight.names,
        dt=dt,
        t=t,
        pos=pos,
        vel=vel,
        axis=axis,
        ref=ref,
        commanded_acc=commanded_acc[nearest],
        feed_forward=flight.eta[nearest, :, 2],
        added_acc=np.zeros((t.size, len(flight.names))),
        outliers=int((bad & visible).sum()),
        samples=int(visible.sum()),
        rates_fitted=bool(given.fitted.any()),
        acc_differentiated=is_differentiated(flight.t, given.vel[..., 2], given.acc[..., 2]),
    )
    return record, given


def _commanded_acc(flight: Flight, vehicle: Vehicle, known: Mask) -> Array:
    acc = flight.thrust / vehicle.mass * body_z(flight)[..., 2] - GRAVITY
    flies = flight.thrust > STANDING * vehicle.hover_thrust
    return np.asarray(np.where(known & flies, acc, np.nan))
