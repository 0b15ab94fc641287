"""Measured vertical push of a recorded flight, from its log or from sensors and commands.

push = faz_est / m                               faz_est [N] = m (a_z + g) - thrust_est, in a log
push = (R f_body)_z - lagged(U1) b_z / m         f_body: accelerometer, U1: commanded thrust

The thrust lag is the vehicle's. It is not fitted to the push: commands answer gusts, and the lag of least
push takes these for thrust. For a true lag of 0.07 s it is 0.16 s in gusts of 0.1 m/s^2, and the downwash
10 % too weak; in real flights, one by one, it is 0.06 to 0.13 s where the motors' log has 0.07 s.

From one tick to the next the later one's command counts, though it is sent only then: so the vehicle's lag
was measured. With the earlier one's, pushes of sensors agree a little less with the jet of the other family
of real flights (R2 0.719 for 0.721 in dc21, 0.632 for 0.633 in dc19), and in simulated flights over a radio
their gain on the true downwash is 1.02 either way. Where a command acts at once, pushes are too strong: 2 %
at 100 Hz, 4 % at 50 Hz, 10 % at 20 Hz.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from q2q_model.counted import counted
from q2q_model.flights.first_order_lag import first_order_lag
from q2q_model.flights.flight import Flight
from q2q_model.flights.flight_log import MOTORS, FlightLog, motor_duty
from q2q_model.flights.interpolated_gaps import interpolate_gaps
from q2q_model.flights.units_and_frames.upright_check import check_upright
from q2q_model.geometry.rotations import UP, level_where_unknown, rotate
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.log_mass import HEAVIEST, LIGHTEST, log_masses
from q2q_model.identification.push.push_samples import FEWEST_FREE, FLOOR, PushRecord
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array, CommandStatus, Mask, Names
from q2q_model.vehicle.constants import VEHICLE_OPTION, Vehicle

MOST_FORCE = 2.0
"""Bound of what 95 % of the forces in a log differ from their median by, over the weight [-]: 0.03 to 0.3 in
recorded flights of 34 g, 3.5 to 30 if those are in gram-force."""
FULL_DUTY = 0.93
"""Duty from which on a motor counts as saturated."""
DUTY_ROUNDING = 1e-6
"""What a duty of FULL_DUTY may lack: single precision rounds by 3e-8, and a step of PWM is 1.5e-5."""


def push_record(one: Recording, vehicle: Vehicle, lag: float) -> PushRecord | None:
    """Return a flight's measured push, from its log or its sensors; None if it has neither.

    Vehicles without a force in the log have that of their sensors.

    Raises:
        ValueError: the vehicle cannot be the one that flew, by the thrust commanded in the air, is not
            upright, the force in the log cannot be in newtons, or its motors are neither duties nor PWM.
    """
    check_upright(one.flight)
    check_weight(one.flight, vehicle)
    log = push_log(one)
    if log is not None:
        check_force(one.flight.name, log, vehicle)
        masses = log_masses(log, one.flight, vehicle)
        logged = push_of_log(one.flight.name, log, motion_of(one.flight), masses)
        return _completed(logged, log, one.flight, vehicle, lag)
    return push_of_sensors(one.flight, vehicle, lag)


def lag_note(recordings: Sequence[Recording], lag: float) -> list[str]:
    """Return a note on the thrust lag [s] if the push of any flight is that of sensors and command."""
    count = sum(push_log(one) is None for one in recordings)
    note = f"push of {counted(count, 'flight')} is from imu and command, with a thrust lag of {lag:g} s"
    return [note] if count else []


def push_log(one: Recording) -> FlightLog | None:
    """Return the log of a flight if its push is in there, else None."""
    return one.log if one.log is not None and _has_push(one.log) else None


class CommandedThrust(NamedTuple):
    """Commanded thrust of the vehicles of a flight, and where they are."""

    flight: str
    """Name of the flight."""
    names: Names
    height: Array
    """[m], (T, n)."""
    thrust: Array
    """U1 [N], (T, n)."""


def check_weight(flight: Flight, vehicle: Vehicle) -> None:
    """Raise ValueError if a vehicle's commanded thrust in the air does not carry the weight of `vehicle`."""
    check_thrust(CommandedThrust(flight.name, flight.names, flight.pos[..., 2], flight.thrust), vehicle)


def check_thrust(commanded: CommandedThrust, vehicle: Vehicle) -> None:
    """Raise ValueError if a vehicle's median thrust in the air does not carry the weight of `vehicle`."""
    for i, name in enumerate(commanded.names):
        thrust = commanded.thrust[commanded.height[:, i] > FLOOR, i]
        thrust = thrust[np.isfinite(thrust)]
        share = float(np.median(thrust)) / vehicle.hover_thrust if thrust.size >= FEWEST_FREE else 1.0
        if not LIGHTEST <= share <= HEAVIEST:
            raise ValueError(
                f"flight {commanded.flight}: the median thrust of {name} in the air is "
                f"{np.median(thrust):.4g} N, {share:.3g} times the weight of {vehicle.name}; must be "
                f"{LIGHTEST:g} to {HEAVIEST:g} times: name the vehicle with {VEHICLE_OPTION} and record "
                "commands in newtons"
            )


def _has_push(log: FlightLog) -> bool:
    """Return whether a log has what push_of_log reads: a vertical force, its gaps, the motors."""
    return {"faz_est", "gap", *MOTORS} <= set(log.columns) and bool(has_values(log, "faz_est").any())


def has_values(log: FlightLog, column: str) -> Mask:
    """Return which vehicles have any value in a column of a log, (n,)."""
    return np.asarray(np.isfinite(log.column(column)).any(axis=0))


def check_force(name: str, log: FlightLog, vehicle: Vehicle) -> None:
    """Raise ValueError if the force of a vehicle in the log of flight `name` cannot be in newtons."""
    for of, force in zip(log.names, log.column("faz_est").T, strict=True):
        known = force[np.isfinite(force)]
        most = float(np.quantile(np.abs(known - np.median(known)), 0.95)) if known.size else 0.0
        if most > MOST_FORCE * vehicle.hover_thrust:
            raise ValueError(
                f"flight {name}: faz_est of {of} varies by {most:.3g} N, "
                f"{most / vehicle.hover_thrust:.3g} times the weight of {vehicle.name}; "
                f"must be at most {MOST_FORCE:g} times: log it in newtons"
            )


def push_of_log(name: str, log: FlightLog, motion: Motion, mass: float | Array) -> PushRecord:
    """Return the vertical push in a flight's log, at the ticks and vehicles of the log and the motion.

    `mass` is m of its force [kg], one for all or (n,). Raises ValueError for motors that are neither duties
    nor PWM.
    """
    force = log.column("faz_est")
    known = np.isfinite(force)
    return PushRecord(
        name=name,
        names=log.names,
        motion=motion,
        push=np.where(known, force / mass, 0.0),
        measured=~_in_gap(log) & known,
        saturated=np.asarray(motor_duty(log, name).max(axis=-1) >= FULL_DUTY - DUTY_ROUNDING),
    )


def _in_gap(log: FlightLog) -> Mask:
    """Return where a log has a gap, or does not know; nowhere for vehicles without that column, (T, n)."""
    return np.asarray((log.column("gap") != 0.0) & has_values(log, "gap"))


def _completed(
    logged: PushRecord, log: FlightLog, flight: Flight, vehicle: Vehicle, lag: float
) -> PushRecord:
    """Return the push of a log with that of sensors for the vehicles without a force in the log."""
    forced = has_values(log, "faz_est")
    sensed = None if forced.all() else push_of_sensors(flight, vehicle, lag)
    if sensed is None:
        return logged
    return replace(
        logged,
        push=np.where(forced, logged.push, sensed.push),
        measured=np.where(forced, logged.measured, sensed.measured & ~_in_gap(log)),
        saturated=logged.saturated | (sensed.saturated & ~forced),
    )


@dataclass(frozen=True, slots=True)
class RecordedAcceleration:
    """Recorded acceleration and command of a flight."""

    t: Array
    specific_force: Array
    """Vertical, (R f_body)_z [m/s^2], (T, n)."""
    thrust: Array
    """Commanded U1 [N], (T, n)."""
    thrust_gain: Array
    """b_z / m [1/kg], (T, n)."""
    known: Mask
    """Where all of them and the position are known, (T, n)."""

    def push(self, lag: float) -> Array:
        """Return the push [m/s^2], (T, n), for a thrust lag [s]; 0 where unknown."""
        return np.where(
            self.known,
            self.specific_force - first_order_lag(self.thrust, self.t, lag) * self.thrust_gain,
            0.0,
        )


def recorded_acceleration(flight: Flight, vehicle: Vehicle) -> RecordedAcceleration | None:
    """Return acceleration and command of a flight; None if it lacks either."""
    specific_force = rotate(flight.quat, flight.specific_force_body)[..., 2]
    thrust_gain = rotate(flight.quat, UP)[..., 2] / vehicle.mass
    known = (
        np.isfinite(specific_force * thrust_gain)
        & np.isfinite(flight.thrust)
        & np.isfinite(flight.pos).all(axis=-1)
    )
    if not known.any():
        return None
    return RecordedAcceleration(flight.t, specific_force, flight.thrust, thrust_gain, np.asarray(known))


def push_of_sensors(flight: Flight, vehicle: Vehicle, lag: float) -> PushRecord | None:
    """Return the push as the difference of accelerometer and command; None if a flight lacks either.

    Args:
        flight: recorded flight.
        vehicle: vehicle, for its mass.
        lag: time constant of thrust [s].
    """
    found = recorded_acceleration(flight, vehicle)
    if found is None:
        return None
    return PushRecord(
        name=flight.name,
        names=flight.names,
        motion=motion_of(flight),
        push=found.push(lag),
        measured=found.known,
        saturated=np.asarray(flight.command_status == CommandStatus.SATURATED),
    )


def motion_of(flight: Flight) -> Motion:
    """Return a flight's filtered motion with interpolated gaps."""
    axis = rotate(level_where_unknown(flight.quat), UP)
    pos, vel = (interpolate_gaps(flight.t, values) for values in (flight.pos, flight.vel))
    return Motion(t=flight.t, pos=pos, vel=vel, axis=axis)
