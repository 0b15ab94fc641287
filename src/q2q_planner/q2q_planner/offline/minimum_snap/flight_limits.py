"""Flight limits: peak speed, acceleration, tilt and yaw rate of a plan, and waypoint times that keep them.

Peaks are bounded by `branch_and_bound` over Bernstein hulls (`bernstein`): norm and tilt, which are
quasi-convex, are at most the largest of the control points.

Times: a rest-to-rest piece s(u) = 35 u^4 - 84 u^5 + 70 u^6 - 20 u^7 over a length D in time T peaks at
35/16 D/T and 84 sqrt(5)/25 D/T^2, so T = max(35/16 D / v_max, sqrt(84 sqrt(5)/25 D / a_max)); exact where
vehicles stop at waypoints. A turn by psi, 3 u^2 - 2 u^3, takes T >= 3/2 |psi| / rate_max, too. Times of free
curves are then scaled by one factor. In every direction thrust is kept by a <= rpyt_thrust_max / m - g
and a <= (1 - LEAST_THRUST) g, and tilt by a <= g sin(tilt).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import ceil, sin, sqrt

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.trajectory.bernstein import control_points, split_in_half
from q2q_model.trajectory.polynomials import Trajectory, derive
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.attitude_limits import LEAST_THRUST, TILT_MAX, YAW_RATE_MAX
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_planner.offline.certificate.branch_and_bound import StretchBounds, least_on_stretches
from q2q_planner.offline.minimum_snap.minimum_snap import Reading, minimum_snap
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint

PEAK_SPEED = 35.0 / 16.0
"""Ratio of largest to mean speed of a rest-to-rest piece: max s'."""
PEAK_ACC = 84.0 * sqrt(5.0) / 25.0
"""max s'' of the rest-to-rest piece."""
PEAK_YAW_RATE = 1.5
"""Ratio of largest to mean yaw rate of a rest-to-rest piece: max s' of 3 u^2 - 2 u^3."""
TOLERANCE = 1e-6
"""Relative excess of a bound over the true peak."""
SMALLEST = 1e-12
"""Absolute excess of a bound over a peak of zero, in the unit of the norm."""
TIME_STEP = 0.01
"""Allocated times are rounded up to a tick [s]."""
ROUNDING = 1e-9
"""Share by which a time or a limit may be off: without it, a time on a tick is lengthened for ever."""


@dataclass(frozen=True, slots=True)
class FlightLimits:
    """Limits of a trajectory."""

    speed: float = tunable(2.0, "largest speed", unit="m/s", low=0.01, high=50.0)
    acceleration: float = tunable(2.0, "largest acceleration", unit="m/s^2", low=0.01, high=100.0)
    """The default leaves controllers half of their tilt: from 3 on, PID saturates in half of its ticks."""
    tilt: float = tunable(TILT_MAX, "largest angle of thrust to vertical", unit="rad", low=0.01, high=1.5)

    def __post_init__(self) -> None:
        """Raise ValueError if a number is out of bounds."""
        check_bounds(self)


@dataclass(frozen=True, slots=True)
class Peak:
    """Largest value of a norm and its time."""

    value: float
    t: float
    """[s]"""


def peak_norm(trajectory: Trajectory, derivative: int, offset: Array | None = None) -> Peak:
    """Return the largest |r^(k) + offset| over all t; the value is a bound from above."""
    derived = derive(trajectory.coefficients[:, :3], derivative).copy()
    if offset is not None:
        derived[..., 0] += offset
    return _peak(derived, trajectory.durations, _norm)


def peak_tilt(trajectory: Trajectory) -> Peak:
    """Return the largest angle of thrust to vertical over all t [rad]; the value is a bound from above."""
    force = derive(trajectory.coefficients[:, :3], 2).copy()
    force[:, 2, 0] += GRAVITY
    return _peak(force, trajectory.durations, _tilt)


def peak_yaw_rate(trajectory: Trajectory) -> Peak:
    """Return the largest |yaw rate| over all t [rad/s]; the value is a bound from above."""
    return _peak(derive(trajectory.coefficients[:, 3:], 1), trajectory.durations, _norm)


def _peak(derived: Array, durations: Array, size: Callable[[Array], Array]) -> Peak:
    """Return the largest size of the polynomials (pieces, axes, order) of the pieces."""
    points = control_points(derived, durations[:, None])  # (pieces, axes, order)
    found = least_on_stretches(points, partial(_size_bounds, size=size), SMALLEST, TOLERANCE)
    start = np.cumsum(durations) - durations
    t = start[found.row] + found.share * durations[found.row]
    return Peak(-found.bound, float(t))


def _size_bounds(points: Array, size: Callable[[Array], Array]) -> StretchBounds:
    """Return the bounds of the negative size: that in the middle, and that of the largest control point."""
    middle = split_in_half(points)[0][..., -1:]
    return StretchBounds(-size(middle)[:, 0], np.full(len(points), 0.5), -size(points).max(-1))


def _norm(points: Array) -> Array:
    """Return the norms of points (m, axes, order), (m, order)."""
    return np.asarray(np.sqrt((points**2).sum(1)))


def _tilt(points: Array) -> Array:
    """Return the angles of points (m, 3, order) to vertical [rad], (m, order); a right angle below."""
    angle = np.arctan2(np.hypot(points[:, 0], points[:, 1]), points[:, 2])
    return np.asarray(np.where(points[:, 2] > 0.0, angle, 0.5 * np.pi))


def with_limits_of(limits: FlightLimits, vehicle: Vehicle) -> FlightLimits:
    """Return limits with the acceleration that the vehicle's thrust and tilt allow in every direction.

    Raises:
        ValueError: the vehicle cannot hover.
    """
    spare = vehicle.rpyt_thrust_max / vehicle.mass - GRAVITY
    if spare <= 0.0:
        raise ValueError(
            f"{vehicle.name}: a thrust of {vehicle.rpyt_thrust_max} N does not lift {vehicle.mass} kg"
        )
    fall = (1.0 - LEAST_THRUST) * GRAVITY
    return replace(limits, acceleration=min(limits.acceleration, spare, fall, GRAVITY * sin(limits.tilt)))


def allocate_times(
    name: str, points: Sequence[Waypoint], limits: FlightLimits, reading: Reading = "stop_and_go"
) -> VehicleWaypoints:
    """Return the waypoints with times that keep the limits; given times are ignored.

    Raises:
        ValueError: a waypoint equals the one before it.
    """
    spans = _least_spans(points, limits)
    if not spans.all():
        still = (
            f"{name}, waypoint {int(spans.argmin()) + 1}: pos and yaw equal those of the previous waypoint"
        )
        raise ValueError(f"{still}: leave it out, or give all waypoints a t [s] that says how long it hovers")
    vehicle = _timed(name, points, np.maximum(spans, TIME_STEP))
    while (slower := _excess(minimum_snap(vehicle, reading), limits)) > 1.0 + ROUNDING:
        vehicle = _timed(name, points, slower * np.diff(vehicle.times))
    return vehicle


def _least_spans(points: Sequence[Waypoint], limits: FlightLimits) -> Array:
    """Return the least times of rest-to-rest pieces between the waypoints [s], (m - 1,)."""
    pos = np.array([waypoint.pos for waypoint in points])
    lengths = np.sqrt((np.diff(pos, axis=0) ** 2).sum(-1))
    turns = np.abs(np.diff([waypoint.yaw for waypoint in points]))
    spans = np.maximum(PEAK_SPEED * lengths / limits.speed, np.sqrt(PEAK_ACC * lengths / limits.acceleration))
    return np.asarray(np.maximum(spans, PEAK_YAW_RATE * turns / YAW_RATE_MAX))


def _excess(trajectory: Trajectory, limits: FlightLimits) -> float:
    """Return by what factor all times must be longer for the limits to hold."""
    speed, acc = peak_norm(trajectory, 1).value, peak_norm(trajectory, 2).value
    turning = peak_yaw_rate(trajectory).value / YAW_RATE_MAX
    return max(speed / limits.speed, sqrt(acc / limits.acceleration), turning)


def _timed(name: str, points: Sequence[Waypoint], spans: Array) -> VehicleWaypoints:
    ticks = [ceil(span / TIME_STEP - ROUNDING) for span in spans]
    times = np.concatenate([[0], np.cumsum(ticks)]) * TIME_STEP
    return VehicleWaypoints(
        name, tuple(replace(point, t=float(t)) for point, t in zip(points, times, strict=True))
    )
