"""Control law of the vehicles of a recorded flight, read from their thrust commands.

    f = a_ref + g e_z + K_p e + K_d e' + K_i xi + c - eta_ff e_z      e = r_ref - r,  xi = integral of e
    T = m f . b,   attitude: b -> f / |f|                             b: body z

(Lee, Leok and McClamroch, CDC 2010, with an integral). T is linear in the gains and in one constant of each
vehicle: a robust regression over all vehicles of a flight gives them. On the recorded flights it leaves 0.006
to 0.015 m/s^2 in swaps and 0.02 to 0.08 in random walks. Lateral gains enter T by the small tilt error only,
so typical ones stand in where a flight says little about them.

The offset c contains errors of the thrust and what the integral had learned before the first row. It is the
one that balances the recorded motion in clear air: the mean of r'' minus all other terms.

Where a velocity setpoint is at its limit (up to half of the rows of a random walk), differentiating it gives
no acceleration, although the controller is given one. There a_ref is read from the command and the attitude.

| symbol | name | meaning [unit] |
|---|---|---|
| K_p K_d K_i | k_p k_d k_i | gains of x, y and z [1/s^2], [1/s], [1/s^3] |
| c | offset | constant acceleration of each vehicle [m/s^2] |
| eta_ff | compensated | downwash that the controller expects [m/s^2] |
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.optimize import least_squares
from scipy.signal import cont2discrete, lfilter

from q2q_control.attitude.attitude_law import AttitudeParams
from q2q_model.geometry.rotations import rotate
from q2q_model.identification.force.downwash_force import Mask
from q2q_model.identification.force.recorded_force import lagged
from q2q_model.identification.gains.altitude_record import UP
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_sim.experiments.validation.rotor_drag import drag_acceleration, read_drag
from q2q_sim.experiments.validation.tracked_flight import TrackedFlight

LIMIT = 0.98
"""Share of its largest value from which a velocity setpoint counts as limited [-]."""
SLOWEST = 0.05
"""Smallest limit of a velocity setpoint [m/s]: a vehicle that is told to hover is not limited."""
AROUND = 3
"""Rows beside a limited one that count as limited too: the differences over them are wrong."""
FEWEST = 200
"""Fewest rows of the regression: 2 s at 100 Hz."""
ROW_ERROR = 0.01
"""Residual of T / m above which a row loses weight [m/s^2]: three times that of a vehicle in clear air."""
TYPICAL = np.array([20.0, 10.0, 0.6])
"""Lateral K_p, K_d, K_i where a flight does not tell: those of the flights of June 2020."""
TYPICAL_SPREAD = 0.5
"""Standard deviation of lateral gains between laws, over their value [-]."""
ROWS_TOGETHER = 100
"""Rows that are one independent one: the residuals of a second have one cause."""

CRITICAL = AttitudeParams(damping=1.0)
"""Attitude loop whose frequency is read from a flight."""
FREQUENCIES = (15.0, 20.0, 30.0, 40.0, 60.0, 80.0)
"""Frequencies of the attitude loop that are tried [rad/s]; above, the lag of the rotors hides them."""


@dataclass(frozen=True, slots=True)
class OnboardLaw:
    """Law of the vehicles of one flight."""

    k_p: Array
    """(3,)"""
    k_d: Array
    """(3,)"""
    k_i: Array
    """(3,)"""
    offset: Array
    """World, (n, 3)."""
    rms: float
    """Standard deviation of the residual of T / m, from the median [m/s^2]."""
    attitude: AttitudeParams = CRITICAL
    """Attitude loop of the plant that tilts as the recorded vehicles did."""


@dataclass(frozen=True, slots=True)
class ReadFlight:
    """Flight with the acceleration reference of its controllers, their law and the drag of the vehicles."""

    flight: TrackedFlight
    law: OnboardLaw
    drag: float = 0.0
    """k of rotor_drag [1/s]."""


def read_law(flight: TrackedFlight, vehicle: Vehicle) -> ReadFlight:
    """Return the law of a flight's vehicles, and the flight with the whole acceleration reference.

    Raises:
        ValueError: fewer than 2 s of commands.
    """
    limited = limited_rows(flight)
    law = _regression(flight, limited, vehicle.mass)
    known = _known(flight, law)  # (T, n, 3)
    attitude = _attitude(flight, known, np.asarray(~limited.any(axis=-1)), vehicle.thrust_lag)
    commanded = _commanded(flight, attitude, vehicle)
    constant = np.stack(
        [
            np.median((commanded - flight.ref_acc - known)[~limited[:, i].any(axis=1), i], axis=0)
            for i in range(len(flight.names))
        ]
    )
    whole = replace(flight, ref_acc=np.where(limited, commanded - known - constant, flight.ref_acc))
    drag = read_drag(flight)
    offset = _offset(whole, known + drag_acceleration(drag, flight.vel, flight.quat), vehicle.thrust_lag)
    return ReadFlight(whole, replace(law, offset=offset, attitude=attitude), drag)


def feedback(law: OnboardLaw, error: Array, rate: Array, integral: Array) -> Array:
    """Return K_p e + K_d e' + K_i xi [m/s^2], (..., 3)."""
    return np.asarray(law.k_p * error + law.k_d * rate + law.k_i * integral)


def limited_rows(flight: TrackedFlight) -> Mask:
    """Return where the velocity setpoint of an axis is at its limit, (T, n, 3)."""
    speed = np.abs(flight.ref_vel)
    at_limit = speed >= LIMIT * np.maximum(speed.max(axis=0), SLOWEST)
    return np.asarray(maximum_filter1d(at_limit, 2 * AROUND + 1, axis=0))


def _known(flight: TrackedFlight, law: OnboardLaw) -> Array:
    """Return the terms of f - g e_z that a recording tells, but a_ref and c, (T, n, 3)."""
    error, rate = flight.ref_pos - flight.pos, flight.ref_vel - flight.vel
    integral = np.cumsum(error, axis=0) * flight.dt
    return np.asarray(feedback(law, error, rate, integral) - flight.compensated[..., None] * UP)


def _regression(flight: TrackedFlight, limited: Mask, mass: float) -> OnboardLaw:
    """Return the gains, with offsets of zero."""
    rows = flight.usable & ~limited.any(axis=-1) & np.isfinite(flight.thrust)
    if rows.sum() < FEWEST:
        raise ValueError(
            f"flight {flight.name} cannot be flown again: {rows.sum()} rows with thrust commands, "
            f"{FEWEST} needed to read the gains of its controllers"
        )
    axis = rotate(flight.quat, UP)
    columns = _columns(flight, axis)[rows]
    plain = flight.ref_acc + (GRAVITY - flight.compensated[..., None]) * UP
    target = (flight.thrust / mass - (plain * axis).sum(axis=-1))[rows]
    scale = np.maximum(np.abs(columns).max(axis=0), 1e-12)
    weight = ROW_ERROR * np.sqrt(ROWS_TOGETHER) / TYPICAL_SPREAD
    prior = np.zeros((3, columns.shape[1]))
    prior[[0, 1, 2], [3, 4, 5]] = weight / TYPICAL
    design, wanted = np.vstack([columns, prior]) / scale, np.append(target, np.full(3, weight))
    found = least_squares(
        lambda x: design @ x - wanted,
        np.zeros(len(scale)),
        jac=lambda _: design,
        loss="soft_l1",
        f_scale=ROW_ERROR,
    )
    vertical, lateral = (found.x / scale)[:3], (found.x / scale)[3:6]
    k_p, k_d, k_i = (np.array([xy, xy, z]) for xy, z in zip(lateral, vertical, strict=True))
    residual = np.abs(columns @ (found.x / scale) - target)
    return OnboardLaw(k_p, k_d, k_i, np.zeros((len(flight.names), 3)), 1.4826 * float(np.median(residual)))


def _columns(flight: TrackedFlight, axis: Array) -> Array:
    """Return the columns of T / m: vertical and lateral gains, then one constant of each vehicle."""
    error, rate = flight.ref_pos - flight.pos, flight.ref_vel - flight.vel
    terms = (error, rate, np.cumsum(error, axis=0) * flight.dt)
    vertical = [axis[..., 2] * term[..., 2] for term in terms]
    lateral = [(axis[..., :2] * term[..., :2]).sum(axis=-1) for term in terms]
    constants = [axis[..., 2] * (np.arange(len(flight.names)) == i) for i in range(len(flight.names))]
    return np.stack([*vertical, *lateral, *constants], axis=-1)


def _commanded(flight: TrackedFlight, attitude: AttitudeParams, vehicle: Vehicle) -> Array:
    """Return f - g e_z [m/s^2], (T, n, 3), from the thrust, and the tilt after the delay of its loop."""
    late = round((vehicle.thrust_lag + 2.0 * attitude.damping / attitude.frequency) / flight.dt)
    axis = rotate(flight.quat, UP)
    axis[:-late, :, :2] = axis[late:, :, :2]
    return np.asarray(flight.thrust[..., None] / vehicle.mass * axis - GRAVITY * UP)


def _offset(flight: TrackedFlight, known: Array, lag: float) -> Array:
    """Return c [m/s^2], (n, 3); the mean of the others for a vehicle without a row in clear air."""
    ticks, n = flight.thrust.shape
    wanted = lagged((flight.ref_acc + known).reshape(ticks, -1), flight.t, lag).reshape(ticks, n, 3)
    missing = np.gradient(flight.vel, flight.dt, axis=0) - wanted
    found = np.array(
        [
            missing[flight.free[:, i], i].mean(axis=0) if flight.free[:, i].any() else [np.nan] * 3
            for i in range(n)
        ]
    )
    return np.where(np.isfinite(found), found, np.nanmean(found, axis=0))


def _attitude(flight: TrackedFlight, known: Array, rows: Mask, lag: float) -> AttitudeParams:
    """Return the attitude loop under which the tilt f_xy / f_z gives the recorded one best in `rows`."""
    force = flight.ref_acc + known + GRAVITY * UP
    axis = rotate(flight.quat, UP)
    wanted, tilt = (part[..., :2] / part[..., 2:] for part in (force, axis))
    wanted, tilt = wanted - wanted.mean(axis=0), tilt - tilt.mean(axis=0)

    def miss(frequency: float) -> float:
        return float(np.median(np.abs(_tilted(wanted, frequency, lag, flight.dt) - tilt)[rows]))

    return replace(CRITICAL, frequency=min(FREQUENCIES, key=miss))


def _tilted(wanted: Array, frequency: float, lag: float, dt: float) -> Array:
    """Return the tilt (T, n, 2) after the attitude loop and the rotors (q2q_control.attitude)."""
    slow = np.polymul([frequency**-2, 2.0 * CRITICAL.damping / frequency, 1.0], [lag, 1.0])
    over, under, _ = cont2discrete((np.ones(1), slow), dt)
    return np.asarray(lfilter(over.ravel(), under, wanted, axis=0))
