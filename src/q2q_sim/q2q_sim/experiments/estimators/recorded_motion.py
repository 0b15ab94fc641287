"""Motion of a vehicle in a recorded flight, every 10 ms, and what its inertial sensors felt.

Position is a cubic spline through the motion capture, velocity its derivative by a polynomial of degree 3
over SMOOTHED ticks (Savitzky, Golay, Anal. Chem. 36, 1964). With the mean over each tick

    a = (v_k - v_k-1) / dt,   f = R^T (a + g e_z),   w = log(q_k-1* q_k) / dt

The axes of the markers are not those of the vehicle: in flight thrust is the only large force, so the
vehicle's z is taken to be the mean direction of f in the markers' axes, and f and w are given in its axes.
Recordings here have no inertial sensors. These follow from the motion capture that the estimates are compared
with: replays show what estimators make of the sensors' errors, not how large those are.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import savgol_filter

from q2q_model.flights.flight import Flight
from q2q_model.flights.interpolated_gaps import nearest_samples, resample
from q2q_model.flights.units_and_frames.unit_check import check_metres
from q2q_model.flights.units_and_frames.upright_check import check_upright
from q2q_model.geometry.rotations import (
    UP,
    ang_vel_between,
    continuous_quats,
    normalised,
    quat_from_vector,
    quat_multiply,
    rotate_inverse,
)
from q2q_model.identification.push.push_samples import FLOOR
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array, Mask
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.firmware.estimator import DT

SMOOTHED = 9
"""Ticks of a derivative: noise of 0.03 mm becomes 1.0 mm/s."""
LIFTED = 0.05
"""Height above the start in flight [m]."""
SLOWEST_HZ = 80.0
"""Minimum rate of motion capture [Hz]: conditions degrade samples at 100 Hz."""
SHORTEST = 5.0
"""Minimum time above FLOOR [s]: a vehicle that hops or tips does not fly."""
ROUNDING = 1e-6
"""Of a time [s]."""
OWN_ESTIMATE = ("est_x", "est_y", "est_z")
"""Columns of a log with the vehicle's own estimate."""


@dataclass(frozen=True, slots=True)
class RecordedMotion:
    """Motion of one vehicle, one row per tick."""

    name: str
    pos: Array
    """Motion capture [m], world, (T, 3)."""
    quat: Array
    """Attitude of the markers, (T, 4)."""
    seen: Mask
    """Ticks with a sample of motion capture, (T,)."""
    flying: Mask
    """Ticks from take-off to landing, (T,)."""
    body_quat: Array
    """Attitude of the vehicle, (T, 4)."""
    specific_force_body: Array
    """Mean over the tick that ends [m/s^2], (T, 3)."""
    ang_vel_body: Array
    """Mean over the tick that ends [rad/s], (T, 3)."""
    own_pos: Array | None
    """The vehicle's own estimate as recorded [m], (T, 3)."""


@dataclass(frozen=True, slots=True)
class _DensePoses:
    """Poses of the markers, one row per tick."""

    sampled: Array
    """Times of the samples of motion capture [s], (S,)."""
    at: Array
    """Times of the ticks [s], (T,)."""
    pos: Array
    """[m], world, (T, 3)."""
    quat: Array
    """(T, 4)"""


def recorded_motion(recording: Recording) -> RecordedMotion:
    """Return the motion in a recording of one vehicle.

    Raises:
        ValueError: several vehicles, no attitudes or none that is upright, a rate below SLOWEST_HZ, or too
            short above FLOOR, or an estimate in the log that is not in metres.
    """
    poses = _dense_poses(recording.flight)
    return _body_motion(recording, poses, in_flight(poses.pos[:, 2]))


def _dense_poses(flight: Flight) -> _DensePoses:
    """Return the poses of a flight; raise as `recorded_motion`."""
    if len(flight.names) != 1:
        raise ValueError(
            f"flight {flight.name} has {len(flight.names)} vehicles; give flights of one vehicle"
        )
    placed, turned = (np.isfinite(one[:, 0]).all(axis=1) for one in (flight.mocap_pos, flight.mocap_quat))
    if placed.any() and not turned.any():
        raise ValueError(f"flight {flight.name} has no attitudes: record them, in a table as qx, qy, qz, qw")
    there = placed & turned
    t = flight.t[there]
    _check_samples(flight.name, t)
    check_upright(flight)
    at = np.arange(t[0], t[-1] + ROUNDING, DT)
    pos = np.asarray(CubicSpline(t, flight.mocap_pos[there, 0])(at))
    quat = normalised(resample(t, continuous_quats(flight.mocap_quat[there, 0]), at))
    high = pos[:, 2] > pos[0, 2] + FLOOR
    if high.sum() < SHORTEST / DT:
        raise ValueError(
            f"flight {flight.name} is {high.sum() * DT:.1f} s more than {FLOOR:g} m above its start; must be "
            f"at least {SHORTEST:g} s"
        )
    return _DensePoses(t, at, pos, quat)


def _check_samples(name: str, t: Array) -> None:
    """Raise ValueError if samples at times (S,) [s] are too rare or too few."""
    rate_hz = 1.0 / float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    if 0.0 < rate_hz < SLOWEST_HZ:
        raise ValueError(
            f"flight {name} has motion capture at {rate_hz:.0f} Hz; must be at least {SLOWEST_HZ:g} Hz, as "
            "it is degraded from 100 Hz"
        )
    if len(t) < SHORTEST / DT:
        raise ValueError(f"flight {name} has {len(t)} poses; must be at least {SHORTEST:g} s of them")


def _body_motion(recording: Recording, poses: _DensePoses, flying: Mask) -> RecordedMotion:
    """Return the motion of the vehicle whose markers have these poses."""
    pos, quat = poses.pos, poses.quat
    vel = savgol_filter(pos, SMOOTHED, 3, deriv=1, delta=DT, axis=0)
    felt = np.diff(vel, axis=0, prepend=vel[:1]) / DT + GRAVITY * UP
    body = quat_multiply(quat, tilt_of(rotate_inverse(quat, felt)[flying].mean(axis=0)))
    before = np.vstack([body[:1], body[:-1]])
    return RecordedMotion(
        name=recording.flight.name,
        pos=pos,
        quat=quat,
        seen=seen_ticks(poses.sampled, poses.at),
        flying=flying,
        body_quat=body,
        specific_force_body=rotate_inverse(normalised(before + body), felt),
        ang_vel_body=ang_vel_between(before, body, DT),
        own_pos=_own(recording, poses.at),
    )


def in_flight(height: Array) -> Mask:
    """Return the ticks from the first to the last at which the vehicle is LIFTED, (T,)."""
    high = np.flatnonzero(height > height[0] + LIFTED)
    flying = np.zeros(len(height), dtype=np.bool_)
    if len(high):
        flying[high[0] : high[-1] + 1] = True
    return flying


def tilt_of(force: Array) -> Array:
    """Return the smallest rotation that turns z to a direction (3,), (4,)."""
    direction = force / np.linalg.norm(force)
    axis = np.cross(UP, direction)
    sine = float(np.linalg.norm(axis))
    return quat_from_vector(axis * (np.arctan2(sine, direction[2]) / sine if sine > 0.0 else 0.0))


def seen_ticks(t: Array, at: Array) -> Mask:
    """Return the ticks `at` with a sample of time `t` within half a tick, (T,).

    Ticks are counted from the mean phase of all samples, as that of the first is off by its jitter.
    """
    phase = DT * float(np.angle(np.exp(2j * np.pi * (t - at[0]) / DT).mean())) / (2.0 * np.pi)
    even = at + phase
    return np.asarray(np.abs(even - t[nearest_samples(t, even)]) <= 0.5 * DT + ROUNDING)


def _own(recording: Recording, at: Array) -> Array | None:
    """Return the vehicle's own estimate at the ticks; raise ValueError if it is not in metres."""
    log = recording.log
    if log is None or not set(OWN_ESTIMATE) <= set(log.columns):
        return None
    own = np.stack([log.column(name)[:, 0] for name in OWN_ESTIMATE], axis=1)
    check_metres((f"the estimate ({', '.join(OWN_ESTIMATE)}) in {recording.flight.name}",), own[:, None])
    return resample(log.t, own, at)
