"""Control law of the vehicles of a recorded flight, read from their thrust commands.

    f = a_ref + g e_z + K_p e + K_d e' + K_i xi + c - eta_ff e_z      e = r_ref - r,  xi = integral of e
    T = m |f|,   attitude: b -> f / |f|                               b: body z

(Morgan, Subramanian, Chung and Hadaegh, IJRR 2016, section 7). A robust regression of T over all vehicles of
a flight (force_regression) gives the gains and one vertical constant of each vehicle. On the recorded flights
it leaves 0.003 to 0.008 m/s^2 in swaps and 0.02 in random walks, and the gains are the same round numbers in
all flights of a family. Recorded commands of the attitude determine the lateral gains: f_xy / f_z is the tilt
that is commanded.

A controller may ignore the downwash that is predicted for it: the law has eta_ff or not, whichever leaves the
smaller residuals. With the wrong one they are 1.3 to 50 times as large on recorded flights of several
vehicles.

The offset c contains errors of the thrust and what the integral had learned before the first row. It is the
one that balances the recorded motion in clear air: the mean of r'' minus all other terms.

The rows of the regression are at samples of the reference, as those of `identify`: between them controllers
may hold it. Where a velocity setpoint is at its limit (velocity_limit), and beside a step without recorded
rates, a_ref is read from the command and the attitude.

| symbol | name | meaning [unit] |
|---|---|---|
| K_p K_d K_i | k_p k_d k_i | gains of x, y and z [1/s^2], [1/s], [1/s^3] |
| c | offset | constant acceleration of each vehicle [m/s^2] |
| eta_ff | compensated | downwash that the controller expects [m/s^2] |
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, cont2discrete, lfilter, sosfiltfilt

from q2q_control.attitude.attitude_law import AttitudeParams
from q2q_model.flights.first_order_lag import first_order_lag
from q2q_model.geometry.rotations import UP, rotate
from q2q_model.identification.gains.velocity_limit import at_velocity_limit
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_sim.air.learning.vehicle_term import LOOP
from q2q_sim.experiments.validation.recorded.force_regression import LEAST_S, fit_force, tracking_errors
from q2q_sim.experiments.validation.recorded.rotor_drag import drag_acceleration, read_drag
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight

TILT_BAND = (0.8, 4.0)
"""Band in which tilts are compared [Hz]. Below, errors of the tilt come back in the command through the
position loop, and the loop seems fast; above, noise of the velocity moves no vehicle, and it seems slow."""
FREQUENCIES = (15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
"""Frequencies of the attitude loop that are tried [rad/s]; above, the lag of the rotors hides them."""


@dataclass(frozen=True, slots=True)
class RecordedLaw:
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
    attitude: AttitudeParams = LOOP
    """Attitude loop of the plant that tilts as the recorded vehicles did."""
    compensates: bool = False
    """Whether eta_ff is subtracted."""


@dataclass(frozen=True, slots=True)
class ReadFlight:
    """Flight with the acceleration reference of its controllers, their law and the drag of the vehicles."""

    flight: TrackedFlight
    law: RecordedLaw
    drag: float = 0.0
    """k of rotor_drag [1/s]."""


def read_law(flight: TrackedFlight, vehicle: Vehicle) -> ReadFlight:
    """Return the law of a flight's vehicles, and the flight with the whole acceleration reference.

    Raises:
        ValueError: fewer than LEAST_S with commands or FEWEST_SAMPLES of references in them, or an unstable
            law.
    """
    limited = at_velocity_limit(flight.ref_vel) | flight.stepped[..., None]  # (T, n, 3)
    flight, law = _compensating(flight, limited, vehicle.mass)
    known = _known(flight, law)  # (T, n, 3)
    attitude = _attitude(flight, known, _steady(flight, limited), vehicle.thrust_lag)
    check_stable(flight.name, replace(law, attitude=attitude), vehicle.thrust_lag, float(flight.t[-1]))
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


def feedback(law: RecordedLaw, error: Array, rate: Array, integral: Array) -> Array:
    """Return K_p e + K_d e' + K_i xi [m/s^2], (..., 3)."""
    return np.asarray(law.k_p * error + law.k_d * rate + law.k_i * integral)


def check_stable(name: str, law: RecordedLaw, lag: float, seconds: float) -> None:
    """Raise ValueError if errors grow e-fold within a flight [s] by its law and rotors of a lag [s].

    They grow as the fastest root of D(s) s^3 + K_d s^2 + K_p s + K_i, D: delay of the tilt or the thrust. The
    recorded vehicles flew by another law, and a comparison with ones that run away says nothing of an air.
    """
    for axis, row, late in (("x and y", 0, _tilt_delay(law.attitude, lag)), ("z", 2, np.array([lag, 1.0]))):
        k_p, k_d, k_i = (float(gains[row]) for gains in (law.k_p, law.k_d, law.k_i))
        growth = np.roots(np.polyadd(np.append(late, np.zeros(3)), [k_d, k_p, k_i])).real.max()
        if growth * seconds > 1.0:
            raise ValueError(
                f"flight {name} cannot be flown again: the gains of {axis} from its thrust commands, "
                f"K_p {k_p:.2f}, K_d {k_d:.2f}, K_i {k_i:.2f}, are unstable: errors grow e-fold in "
                f"{1.0 / growth:.2g} s of {seconds:.0f} s; give a flight whose errors along {axis} show in "
                "its thrust"
            )


def _steady(flight: TrackedFlight, limited: Mask) -> Mask:
    """Return the rows in clear air without a limited setpoint, or all of the latter if few, (T, n)."""
    unlimited = ~limited.any(axis=-1)
    clear = unlimited & flight.free & flight.usable
    return np.asarray(clear if clear.sum() * flight.dt >= LEAST_S else unlimited)


def _known(flight: TrackedFlight, law: RecordedLaw) -> Array:
    """Return the terms of f - g e_z that a recording determines, but a_ref and c, (T, n, 3)."""
    return np.asarray(feedback(law, *tracking_errors(flight)) - flight.compensated[..., None] * UP)


def _compensating(flight: TrackedFlight, limited: Mask, mass: float) -> tuple[TrackedFlight, RecordedLaw]:
    """Return the law that explains the commands better, with eta_ff or without, and the flight by it."""
    flown = [flight]
    if flight.compensated.any():
        flown.append(replace(flight, compensated=np.zeros_like(flight.compensated), model=None))
    fits = [fit_force(one, limited, mass) for one in flown]
    fit, best = min(zip(fits, flown, strict=True), key=lambda pair: pair[0].loss)
    still = np.zeros((len(flight.names), 3))
    return best, RecordedLaw(
        fit.k_p, fit.k_d, fit.k_i, still, fit.rms, compensates=bool(best.compensated.any())
    )


def _commanded(flight: TrackedFlight, attitude: AttitudeParams, vehicle: Vehicle) -> Array:
    """Return f - g e_z [m/s^2], (T, n, 3), from the thrust, and the tilt after the delay of its loop."""
    lead = attitude.lead_ratio * vehicle.thrust_lag
    late = round((lead + 2.0 * attitude.damping / attitude.frequency) / flight.dt)
    axis = rotate(flight.quat, UP)
    axis[:-late, :, :2] = axis[late:, :, :2]
    return np.asarray(flight.thrust[..., None] / vehicle.mass * axis - GRAVITY * UP)


def _offset(flight: TrackedFlight, known: Array, lag: float) -> Array:
    """Return c [m/s^2], (n, 3); the mean of the others for a vehicle without a row in clear air."""
    ticks, n = flight.thrust.shape
    wanted = first_order_lag((flight.ref_acc + known).reshape(ticks, -1), flight.t, lag).reshape(ticks, n, 3)
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

    band = butter(2, TILT_BAND, "bandpass", fs=1.0 / flight.dt, output="sos")

    def miss(frequency: float) -> float:
        slow = _tilt_delay(replace(LOOP, frequency=frequency), lag)
        over, under, _ = cont2discrete((np.ones(1), slow), flight.dt)
        missed = sosfiltfilt(band, lfilter(over.ravel(), under, wanted, axis=0) - tilt, axis=0)
        return float(np.median(np.abs(missed)[rows]))

    return replace(LOOP, frequency=min(FREQUENCIES, key=miss))


def _tilt_delay(loop: AttitudeParams, lag: float) -> Array:
    """Return D of a tilt after the attitude loop and the rotors, which is 1 / D(s) of the wanted one, (4,).

    With a lead l and a lag T, D is 1 + (2 zeta / w + l) s + (1 / w^2 + 2 zeta l / w) s^2 + T / w^2 s^3; its
    highest power comes first.
    """
    lead, damped = loop.lead_ratio * lag, 2.0 * loop.damping / loop.frequency
    return np.array([lag * loop.frequency**-2, loop.frequency**-2 + damped * lead, damped + lead, 1.0])
