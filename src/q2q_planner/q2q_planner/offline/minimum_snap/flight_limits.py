"""Flight limits: peak speed, acceleration, thrust and yaw rate of a plan, and waypoint times that keep them.

Peaks are bounded by `branch_and_bound` over Bernstein hulls (`bernstein`): the norm of a curve is at most the
largest norm of its control points.

Times: a rest-to-rest piece s(u) = 35 u^4 - 84 u^5 + 70 u^6 - 20 u^7 over a length D in time T peaks at
35/16 D/T and 84 sqrt(5)/25 D/T^2, so T = max(35/16 D / v_max, sqrt(84 sqrt(5)/25 D / a_max)); exact where
vehicles stop at waypoints. A turn by psi, 3 u^2 - 2 u^3, takes T >= 3/2 |psi| / rate_max, too. Times of free
curves are then scaled by one factor. Thrust is kept by a <= rpyt_thrust_max / m - g in every direction.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, sqrt

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.trajectory.bernstein import control_points, split_in_half
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory, derive
from q2q_model.tunable import check_bounds, tunable
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
YAW_RATE = 3.5
"""Largest yaw rate [rad/s]: the largest that the controllers command, `yaw_rate_max` of PID and MPC."""
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
    acceleration: float = tunable(4.0, "largest acceleration", unit="m/s^2", low=0.01, high=100.0)

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
    return _peak(derived, trajectory.durations)


def peak_yaw_rate(trajectory: Trajectory) -> Peak:
    """Return the largest |yaw rate| over all t [rad/s]; the value is a bound from above."""
    return _peak(derive(trajectory.coefficients[:, 3:], 1), trajectory.durations)


def _peak(derived: Array, durations: Array) -> Peak:
    """Return the largest norm of the polynomials (pieces, axes, order) of the pieces."""
    points = control_points(derived, durations[:, None])  # (pieces, axes, order)
    found = least_on_stretches(points, _norm_bounds, SMALLEST, TOLERANCE)
    start = np.cumsum(durations) - durations
    t = start[found.row] + found.share * durations[found.row]
    return Peak(-found.bound, float(t))


def _norm_bounds(points: Array) -> StretchBounds:
    """Return the bounds of the negative norm: that in the middle, and that of the largest control point."""
    middle = split_in_half(points)[0][..., -1]
    norms = np.sqrt((points**2).sum(1)).max(-1)
    return StretchBounds(-np.sqrt((middle**2).sum(-1)), np.full(len(points), 0.5), -norms)


def check_feasible(
    plan: SwarmPlan, swarm: Sequence[VehicleWaypoints], vehicle: Vehicle, reserve: float = 0.0
) -> None:
    """Raise ValueError with vehicle, waypoint and bound if a trajectory needs too much thrust or yaw rate.

    `reserve` is the acceleration that the thrust must give on top of the plan's, in any direction [m/s^2].
    """
    for trajectory, waypoints in zip(plan.trajectories, swarm, strict=True):
        peak = peak_norm(trajectory, 2, np.array([0.0, 0.0, GRAVITY]))
        thrust = vehicle.mass * (peak.value + reserve)
        if thrust > vehicle.rpyt_thrust_max:
            most = f"{vehicle.name} has at most {vehicle.rpyt_thrust_max:.3g} N"
            needs = f"needs {thrust:.3g} N of thrust, {most}; allow more time"
            raise ValueError(f"{_place(waypoints, peak)}: {needs}")
        _check_yaw_rate(peak_yaw_rate(trajectory), waypoints)


def _check_yaw_rate(peak: Peak, waypoints: VehicleWaypoints) -> None:
    if peak.value > YAW_RATE * (1.0 + ROUNDING):
        turns = f"turns at {peak.value:.3g} rad/s, allowed is {YAW_RATE:g} rad/s"
        yaw = "yaw is in radians and not wrapped: 0 to 6.28 is a full turn"
        raise ValueError(f"{_place(waypoints, peak)}: {turns}; allow more time, or turn less ({yaw})")


def _place(waypoints: VehicleWaypoints, peak: Peak) -> str:
    """Return vehicle, waypoint and time of a peak, in words."""
    after = int(np.searchsorted(waypoints.times, peak.t, side="right")) - 1
    return f"{waypoints.name}, after waypoint {after} (t = {peak.t:.2f} s)"


def with_limits_of(limits: FlightLimits, vehicle: Vehicle) -> FlightLimits:
    """Return limits with the acceleration that the vehicle's thrust allows in every direction.

    Raises:
        ValueError: the vehicle cannot hover.
    """
    spare = vehicle.rpyt_thrust_max / vehicle.mass - GRAVITY
    if spare <= 0.0:
        raise ValueError(f"{vehicle.name}: {vehicle.rpyt_thrust_max} N does not carry {vehicle.mass} kg")
    return replace(limits, acceleration=min(limits.acceleration, spare))


def allocate_times(
    name: str, points: Sequence[Waypoint], limits: FlightLimits, reading: Reading = "stop_and_go"
) -> VehicleWaypoints:
    """Return the waypoints with times that keep the limits; given times are ignored.

    Raises:
        ValueError: a waypoint equals the one before it.
    """
    spans = _least_spans(points, limits)
    if not spans.all():
        still = f"{name}, waypoint {int(spans.argmin()) + 1}: pos and yaw are those of the one before it"
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
    return np.asarray(np.maximum(spans, PEAK_YAW_RATE * turns / YAW_RATE))


def _excess(trajectory: Trajectory, limits: FlightLimits) -> float:
    """Return by what factor all times must be longer for the limits to hold."""
    speed, acc = peak_norm(trajectory, 1).value, peak_norm(trajectory, 2).value
    turning = peak_yaw_rate(trajectory).value / YAW_RATE
    return max(speed / limits.speed, sqrt(acc / limits.acceleration), turning)


def _timed(name: str, points: Sequence[Waypoint], spans: Array) -> VehicleWaypoints:
    ticks = [ceil(span / TIME_STEP - ROUNDING) for span in spans]
    times = np.concatenate([[0], np.cumsum(ticks)]) * TIME_STEP
    return VehicleWaypoints(
        name, tuple(replace(point, t=float(t)) for point, t in zip(points, times, strict=True))
    )
