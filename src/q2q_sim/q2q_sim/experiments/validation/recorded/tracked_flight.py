"""References, states and commands of a recorded flight, on an even grid from take-off to landing.

The rows under a wake and in clear air are those of the scoring rule of pushes
(q2q_model.identification.push.push_samples).
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.flights.flight import Flight
from q2q_model.flights.flight_log import FlightLog
from q2q_model.flights.interpolated_gaps import nearest_samples, resample
from q2q_model.flights.sampled_reference import SampledReference, flown_reference, setpoint_positions
from q2q_model.geometry.rotations import UP, normalised, quat_from_euler, rotate, yaw_from_quat
from q2q_model.identification.push.along_flight import Motion, eta_along
from q2q_model.identification.push.push_samples import FEWEST_FREE, FLOOR, scored_rows
from q2q_model.identification.push.recorded_push import push_record
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_names import ModelFileError
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array, Mask, Names, Rows
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_sim.air.learning.records.air_record import air_records
from q2q_sim.air.learning.records.motor_curve import motor_curves, usual_power

SHORTEST = 5.0
"""Shortest flight that is compared [s]: one period of the slowest frequency, 0.2 Hz."""
PREDICTED = 0.1
"""Largest rms difference of a model's prediction from the recorded one, over the latter [-]: that of the very
model differs only where states were lost; a model that was refined in flight, or changed since, by more."""
NEAR = 0.9
"""Farthest row that counts as recorded at a time [periods]: stamps jitter; next to a lost row it is 1."""


@dataclass(frozen=True, slots=True)
class TrackedFlight:
    """Recorded flight that the simulator can fly again."""

    name: str
    names: Names
    dt: float
    """Time between rows [s]."""
    pos: Array
    """Estimate of the controller [m], world, (T, n, 3)."""
    vel: Array
    """[m/s], world, (T, n, 3)."""
    quat: Array
    """Body to world, (T, n, 4)."""
    ref_pos: Array
    """Setpoint of the controller, else the plan [m], world, (T, n, 3)."""
    ref_vel: Array
    """[m/s], world, (T, n, 3)."""
    ref_acc: Array
    """[m/s^2], world, (T, n, 3)."""
    acc: Array
    """Acceleration by the accelerometer [m/s^2], world, NaN without one, (T, n, 3)."""
    thrust: Array
    """Commanded collective thrust [N], (T, n)."""
    compensated: Array
    """Downwash that the controller expects [m/s^2], along z, (T, n); 0 where it knows none."""
    usable: Mask
    """Rows that were measured, above the ground and without a saturated motor, (T, n)."""
    exposed: Mask
    """Rows under another vehicle, (T, n)."""
    free: Mask
    """Rows in clear air, (T, n)."""
    scored: Mask
    """Vehicles with enough rows in clear air to be compared, (n,)."""
    sure: Mask
    """Rows at samples of the reference whose rates were recorded or are those of a smooth motion, (T, n)."""
    stepped: Mask
    """Rows whose nearest sample of the reference has no such rates, as at a step, (T, n)."""
    tilt: Array | None = None
    """Commanded x and y of body z over its z, world, (T, n, 2); None where attitudes were not recorded."""
    model: InteractionModel | None = None
    """Model whose prediction `compensated` is; None where it is not known."""
    headroom: Array | None = None
    """Largest thrust of each rotor over that at hover, at the start, (n, 4); None without a motor log."""

    @property
    def t(self) -> Array:
        """Return the time since the first row [s], (T,)."""
        return np.asarray(self.dt * np.arange(len(self.pos)), dtype=np.float64)

    @property
    def error(self) -> Array:
        """Return z - z_ref [m], (T, n)."""
        return np.asarray(self.pos[..., 2] - self.ref_pos[..., 2])


def tracked_flight(recording: Recording, vehicle: Vehicle) -> TrackedFlight:
    """Return the flight of a recording from the take-off of the last vehicle to the first landing.

    Raises:
        ValueError: the recording lacks references or commands, or no 5 s with all vehicles in the air.
    """
    flight = recording.flight
    pushes = push_record(recording, vehicle, vehicle.thrust_lag)
    known = (np.isfinite(one).any() for one in (setpoint_positions(flight), flight.thrust))
    if pushes is None or not all(known):
        raise ValueError(
            f"flight {flight.name} cannot be flown again: record references, states and thrust commands"
        )
    usable, exposed, free = (
        np.stack(masks, axis=1)
        for masks in zip(*((row.usable, row.exposed, row.free) for row in scored_rows(pushes)), strict=True)
    )
    grid = flying_grid(flight)
    nearest, there = _nearest_rows(flight.t, grid)
    reference = flown_reference(flight)
    compensated = _compensated(flight, recording.log, vehicle.mass)
    return TrackedFlight(
        name=flight.name,
        names=flight.names,
        dt=float(grid[1] - grid[0]),
        pos=resample(flight.t, flight.pos, grid),
        vel=resample(flight.t, flight.vel, grid),
        quat=normalised(resample(flight.t, flight.quat, grid)),
        ref_pos=resample(flight.t, reference.pos, grid),
        ref_vel=resample(flight.t, reference.vel, grid),
        ref_acc=resample(flight.t, reference.acc, grid),
        acc=resample(flight.t, rotate(flight.quat, flight.specific_force_body) - GRAVITY * UP, grid),
        thrust=resample(flight.t, flight.thrust, grid),
        compensated=resample(flight.t, compensated, grid),
        usable=usable[nearest] & there[:, None],
        exposed=exposed[nearest] & there[:, None],
        free=free[nearest] & there[:, None],
        scored=np.asarray(free.sum(axis=0) >= FEWEST_FREE),
        sure=reference.sure[nearest] & there[:, None],
        stepped=_stepped(reference, flight.t, grid),
        tilt=_commanded_tilt(flight, grid),
        model=_predicting_model(recording, compensated),
        headroom=recorded_headroom(recording, vehicle),
    )


def _nearest_rows(t: Array, grid: Array) -> tuple[Rows, Mask]:
    """Return the row nearest to each time, and whether it is near enough to have been recorded then."""
    nearest = nearest_samples(t, grid)
    return nearest, np.asarray(np.abs(t[nearest] - grid) < NEAR * (grid[1] - grid[0]))


def _stepped(reference: SampledReference, t: Array, grid: Array) -> Mask:
    """Return the times whose nearest sample of each vehicle's reference is not sure, (T, n)."""
    sampled = [np.flatnonzero(np.isfinite(pos).all(axis=-1)) for pos in reference.pos.swapaxes(0, 1)]
    near = [rows[nearest_samples(t[rows], grid)] for rows in sampled]
    return np.stack([~reference.sure[rows, i] for i, rows in enumerate(near)], axis=1)


def recorded_headroom(recording: Recording, vehicle: Vehicle) -> Array | None:
    """Return the largest thrust of each rotor over that at hover by the motor curves, (n, 4).

    None if a vehicle has no log of its motors, or flies for less than 5 s.
    """
    records, _ = air_records([recording], vehicle, vehicle.thrust_lag)
    curves = motor_curves(records)
    if not curves or len(curves) < records[0].vehicles:
        return None
    power = usual_power(curves)
    return np.array([one.headroom(one.start_volts, power) / one.work for one in curves])


def _compensated(flight: Flight, log: FlightLog | None, mass: float) -> Array:
    """Return the feed-forward [m/s^2], (T, n): the log's onboard estimate, else the predicted downwash."""
    if log is not None and "fa_ff" in log.columns:
        return np.nan_to_num(log.column("fa_ff") / mass)
    return np.nan_to_num(flight.eta[..., 2])


def _commanded_tilt(flight: Flight, grid: Array) -> Array | None:
    """Return x and y of the commanded body z over its z, world, (T, n, 2); None without such commands."""
    axis = rotate(quat_from_euler(flight.roll, flight.pitch, yaw_from_quat(flight.quat)), UP)
    tilt = axis[..., :2] / axis[..., 2:]
    return resample(flight.t, tilt, grid) if np.isfinite(tilt).any(axis=(0, 2)).all() else None


def _predicting_model(recording: Recording, compensated: Array) -> InteractionModel | None:
    """Return the model that a recording names, if it predicts this downwash (T, n) of the recorded states."""
    flight, recorded = recording.flight, np.linalg.norm(compensated)
    if not recording.model or recorded == 0.0:
        return None
    try:
        model = find_model(recording.model).interaction
    except ModelFileError:  # a file of another machine, or since deleted
        return None
    predicted = eta_along(model, Motion(flight.t, flight.pos, flight.vel, rotate(flight.quat, UP)))[..., 2]
    missed = np.where(compensated != 0.0, predicted - compensated, 0.0)
    return model if np.linalg.norm(missed) <= PREDICTED * recorded else None


def flying_grid(flight: Flight) -> Array:
    """Return the even times (T,) [s] between the first and the last row with all vehicles in the air.

    Raises:
        ValueError: fewer than 5 s.
    """
    height = flight.pos[..., 2]
    referred = np.isfinite(setpoint_positions(flight)).all(axis=(1, 2))
    flying = np.nonzero((height > FLOOR).all(axis=1) & referred)[0]
    if flying.size == 0 or flight.t[flying[-1]] - flight.t[flying[0]] < SHORTEST:
        raise ValueError(
            f"flight {flight.name} cannot be flown again: its vehicles are never all above {FLOOR} m "
            f"for {SHORTEST:.0f} s"
        )
    dt = float(np.median(np.diff(flight.t)))
    return np.arange(flight.t[flying[0]], flight.t[flying[-1]] + 1e-9, dt)
