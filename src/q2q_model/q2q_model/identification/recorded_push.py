"""Read the measured vertical push out of a recorded flight: from its log, or from sensors and commands.

push = faz_est / m_log                           logs of two and three Crazyflies (Neural-Swarm2, T-RO 2021)
push = (R f_body)_z - lagged(U1) b_z / m         f_body: accelerometer, U1: commanded thrust
"""

import numpy as np
from scipy.signal import lfilter

from q2q_model.flight_log import FlightLog
from q2q_model.flights import Flight
from q2q_model.identification.along_flight import Motion
from q2q_model.identification.altitude_record import UP
from q2q_model.identification.draft_force import ForceRecord
from q2q_model.rotations import rotate
from q2q_model.signals import Array, CommandStatus
from q2q_model.vehicle import Vehicle

LOG_MASS = 0.032
"""Mass that the logs' faz_est was computed with [kg]."""
FULL_DUTY = 0.93
"""Duty above which a motor counts as saturated."""
MOTORS = ("pwm1", "pwm2", "pwm3", "pwm4")


def is_force_log(log: FlightLog) -> bool:
    """Return whether a log shows the vertical push and what tells its good rows."""
    return {"faz_est", "gap", *MOTORS} <= set(log.columns)


def push_of_log(name: str, log: FlightLog, motion: Motion) -> ForceRecord:
    """Return the vertical push that a flight's log shows, at the log's ticks."""
    duty = np.max([log.column(motor) for motor in MOTORS], axis=0)  # (T, n)
    return ForceRecord(
        name=name,
        names=log.names,
        motion=motion,
        push=log.column("faz_est") / LOG_MASS,
        whole=log.column("gap") == 0.0,
        saturated=duty > FULL_DUTY,
    )


def push_of_sensors(flight: Flight, vehicle: Vehicle, lag: float) -> ForceRecord | None:
    """Return the push between accelerometer and command; None where a flight lacks either.

    Args:
        flight: the flight.
        vehicle: whose mass.
        lag: time constant of thrust behind its command [s].
    """
    force = rotate(flight.quat, flight.specific_force_body)[..., 2]
    axis = rotate(flight.quat, UP)
    given = lagged(flight.thrust, flight.t, lag) * axis[..., 2] / vehicle.mass
    push = force - given
    whole = np.asarray(np.isfinite(push) & np.isfinite(flight.thrust) & np.isfinite(flight.pos).all(axis=-1))
    if not whole.any():
        return None
    return ForceRecord(
        name=flight.name,
        names=flight.names,
        motion=motion_of(flight),
        push=np.where(whole, push, 0.0),
        whole=whole,
        saturated=np.asarray(flight.command_status == CommandStatus.SATURATED),
    )


def motion_of(flight: Flight) -> Motion:
    """Return a flight's filtered motion, its holes on lines between what is known."""
    level = np.isfinite(flight.quat).all(axis=-1, keepdims=True)
    axis = rotate(np.where(level, flight.quat, [0.0, 0.0, 0.0, 1.0]), UP)
    pos, vel = (_filled(flight.t, values) for values in (flight.pos, flight.vel))
    return Motion(t=flight.t, pos=pos, vel=vel, axis=axis)


def lagged(values: Array, t: Array, lag: float) -> Array:
    """Return values (T, n) behind a first-order lag [s]; a missing one (NaN) counts as the one before."""
    known = _filled(t, values)
    if lag <= 0.0:
        return known
    keep = np.exp(-float(np.median(np.diff(t))) / lag)
    out, _ = lfilter([1.0 - keep], [1.0, -keep], known, axis=0, zi=keep * known[:1])
    return np.asarray(out)


def _filled(t: Array, values: Array) -> Array:
    columns = values.reshape(t.size, -1).copy()
    for column in columns.T:
        good = np.isfinite(column)
        if good.any():
            column[~good] = np.interp(t[~good], t[good], column[good])
        else:
            column[:] = 0.0
    return columns.reshape(values.shape)
