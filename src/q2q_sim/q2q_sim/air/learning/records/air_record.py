"""A recorded flight as the terms of an air need it: motion, measured push, thrust, motors and battery.

The vertical downwash and its rows are those of q2q_model.identification.push.push_samples. The thrust ratio
of a source is its thrust over that of its own clear air, so that neither its mass nor its thrust map enters.
A row without a thrust is a gap, as is one without an acceleration or rate of a vehicle that has others;
thrust and rates are interpolated there, for rows that depend on their neighbours.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.flights.first_order_lag import first_order_lag
from q2q_model.flights.flight_log import MOTORS, motor_duty
from q2q_model.flights.outliers import repair
from q2q_model.geometry.rotations import rotate
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.log_column_note import log_column_notes
from q2q_model.identification.push.push_samples import (
    APART,
    FEWEST_FREE,
    FLOOR,
    PushSamples,
    known_rows,
    push_samples,
)
from q2q_model.identification.push.recorded_push import has_values, push_record
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array, Mask, Names
from q2q_model.vehicle.constants import Vehicle

THRUST = "thrust_est"
"""Log column of the thrust by duty and voltage [N]."""
FLYING = 0.7
"""Thrust over hover thrust above which a vehicle flies [-]."""
MANY_GAPS = 0.1
"""Share of a vehicle's rows that are gaps from which on that is reported."""


@dataclass(frozen=True, slots=True)
class Motors:
    """Motors and battery of a flight."""

    duty: Array
    """Motor duty, 0 to 1, (T, n, 4)."""
    volts: Array
    """Battery voltage [V], (T, n)."""


@dataclass(frozen=True, slots=True)
class AirRecord:
    """Recorded flight with what the terms of an air are learned from."""

    name: str
    motion: Motion
    samples: tuple[PushSamples, ...]
    """Vertical downwash of each vehicle with enough rows in clear air."""
    gaps: Mask
    """Rows that lack a thrust, or an acceleration or rate of which the vehicle has others, (T, n)."""
    measured: Mask
    """Rows known by the scoring rule, without a saturated motor of this vehicle, at any height, (T, n)."""
    clear: Mask
    """Those above the ground effect with no vehicle near horizontally, (T, n)."""
    specific_force: Array
    """Accelerometer in the world frame, (a + g e_z) [m/s^2], (T, n, 3)."""
    command: Array
    """Commanded thrust after the thrust lag [N], (T, n); NaN of a vehicle without any command."""
    thrust: Array
    """Thrust of the rotors [N], (T, n)."""
    thrust_ratio: Array
    """Thrust over the vehicle's own in clear air [-], (T, n)."""
    quat: Array
    """(T, n, 4)"""
    rate_body: Array
    """Body rates [rad/s], (T, n, 3)."""
    lag: float
    """Time constant of thrust of all flights [s]."""
    motors: Motors | None
    """None if the flight has no log of them."""

    @property
    def vehicles(self) -> int:
        """Return the number of vehicles."""
        return int(self.motion.pos.shape[1])

    @property
    def flying(self) -> Mask:
        """Return the rows in which a vehicle flies by its thrust, (T, n)."""
        return np.asarray(self.thrust_ratio > FLYING)

    @property
    def felt(self) -> Mask:
        """Return the clear rows of vehicles with an accelerometer, (T, n)."""
        return np.asarray(self.clear & np.isfinite(self.specific_force).all(axis=-1))


def air_records(
    recordings: Sequence[Recording], vehicle: Vehicle, lag: float
) -> tuple[list[AirRecord], list[str]]:
    """Return the records of flights with a measured push, and notes on other flights and on vehicles.

    Args:
        recordings: flights.
        vehicle: the vehicle that flew.
        lag: time constant of thrust [s].
    """
    found, notes = [], log_column_notes(recordings, vehicle)
    for one in recordings:
        record = _record(one, vehicle, lag)
        if record is None:
            notes.append(
                f"{one.flight.name} has no measured push: record imu and command, or faz_est, thrust_est, "
                "gap and pwm1-4"
            )
        elif not np.isfinite(record.thrust).any():
            notes.append(
                f"{record.name} has no thrust, to which a jet is proportional: record command, or "
                "thrust_est beside faz_est"
            )
        elif not record.measured.any():
            notes.append(
                f"{record.name} has no usable row: in each, the vehicle or one near it has no data or a "
                "motor is saturated"
            )
        else:
            found.append(record)
            notes += _remarks(record, one.flight.names)
    return found, notes


def _remarks(record: AirRecord, names: Names) -> list[str]:
    """Return remarks on the vehicles without a usable row, and on those with many gaps, if there are any."""
    idle = [name for name, rows in zip(names, record.measured.T, strict=True) if not rows.any()]
    shares = zip(names, record.gaps.mean(axis=0), strict=True)
    gaps = [f"{share:.0%} of {name}" for name, share in shares if share >= MANY_GAPS and name not in idle]
    told = {"no usable row of": idle, "rows without thrust, acceleration or rates are gaps:": gaps}
    return [f"{record.name}: {what} {', '.join(found)}" for what, found in told.items() if found]


def _record(one: Recording, vehicle: Vehicle, lag: float) -> AirRecord | None:
    pushes = push_record(one, vehicle, lag)
    if pushes is None:
        return None
    flight, t = one.flight, one.flight.t
    commanded = np.isfinite(flight.thrust).any(axis=0)
    command = np.where(commanded, first_order_lag(flight.thrust, t, lag), np.nan)
    thrust = command
    if one.log and THRUST in one.log.columns:
        thrust = np.where(has_values(one.log, THRUST), one.log.column(THRUST), command)
    specific_force = rotate(flight.quat, flight.specific_force_body)
    gaps = ~np.isfinite(thrust) | _lost(specific_force) | _lost(flight.gyro_body)
    pushes = replace(pushes, measured=pushes.measured & ~gaps)
    thrust = _filled(t, thrust[..., None])[..., 0]
    measured: Mask = known_rows(pushes) & ~pushes.saturated
    clear = measured & (pushes.motion.pos[..., 2] > FLOOR) & rows_alone(pushes.motion.pos, APART)
    return AirRecord(
        name=flight.name,
        motion=pushes.motion,
        samples=tuple(push_samples(pushes)),
        gaps=gaps,
        measured=measured,
        clear=clear,
        specific_force=specific_force,
        command=command,
        thrust=thrust,
        thrust_ratio=_thrust_ratio(thrust, clear, measured),
        quat=flight.quat,
        rate_body=_filled(t, flight.gyro_body),
        lag=lag,
        motors=_motors(one),
    )


def _lost(values: Array) -> Mask:
    """Return where a vehicle lacks a value (T, n, c) of which it has others, (T, n)."""
    known = np.isfinite(values).all(axis=-1)
    return np.asarray(~known & known.any(axis=0))


def _filled(t: Array, values: Array) -> Array:
    """Return values (T, n, c) interpolated where they are lost; NaN of a vehicle without any."""
    return repair(t, values, np.asarray(~np.isfinite(values).all(axis=-1)))


def rows_alone(pos: Array, distance: float) -> Mask:
    """Return the rows with every neighbour farther than `distance` [m] horizontally, (T, n)."""
    alone = np.empty(pos.shape[:2], dtype=np.bool_)
    for i in range(pos.shape[1]):
        rel = np.delete(pos, i, axis=1)[..., :2] - pos[:, i : i + 1, :2]  # (T, n - 1, 2)
        alone[:, i] = (np.linalg.norm(rel, axis=-1) > distance).all(axis=1)
    return alone


def _thrust_ratio(thrust: Array, clear: Mask, measured: Mask) -> Array:
    """Return thrust over its median in clear air, or over all measured rows where too few are clear."""
    rows = np.where(clear.sum(axis=0) >= FEWEST_FREE, clear, measured)
    usual = [np.median(thrust[rows[:, i], i]) if rows[:, i].any() else 1.0 for i in range(thrust.shape[1])]
    return np.asarray(thrust / np.array(usual))


def _motors(one: Recording) -> Motors | None:
    if one.log is None or not {*MOTORS, "vbat"} <= set(one.log.columns):
        return None
    return Motors(motor_duty(one.log, one.flight.name), one.log.column("vbat"))
