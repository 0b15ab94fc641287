"""Whether a vehicle can fly a plan: thrust, tilt and yaw rate, bounded for every t (`flight_limits`)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory
from q2q_model.vehicle.attitude_limits import TILT_MAX, YAW_RATE_MAX
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_planner.offline.certificate.upward_thrust import UpwardThrust, least_upward_thrust
from q2q_planner.offline.minimum_snap.flight_limits import (
    ROUNDING,
    Peak,
    peak_norm,
    peak_tilt,
    peak_yaw_rate,
)
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints


class NotFlyableError(ValueError):
    """Error that names vehicle, waypoint and bound that a trajectory exceeds."""


class PlanPeaks(NamedTuple):
    """Largest values of a plan, over all vehicles and times; bounds from above."""

    speed: float
    """[m/s]"""
    acceleration: float
    """[m/s^2]"""
    tilt: float
    """Angle of thrust to vertical [rad]."""


def plan_peaks(plan: SwarmPlan) -> PlanPeaks:
    """Return the largest speed, acceleration and tilt of a plan."""
    curves = plan.trajectories
    return PlanPeaks(
        max(peak_norm(curve, 1).value for curve in curves),
        max(peak_norm(curve, 2).value for curve in curves),
        max(peak_tilt(curve).value for curve in curves),
    )


def check_feasible(
    plan: SwarmPlan,
    swarm: Sequence[VehicleWaypoints],
    vehicle: Vehicle,
    reserve: float = 0.0,
    tilt_max: float = TILT_MAX,
) -> None:
    """Raise NotFlyableError if a trajectory needs too much or too little thrust, too much tilt or yaw rate.

    Args:
        plan: to be flown.
        swarm: its waypoints.
        vehicle: that flies it.
        reserve: acceleration that the thrust must give on top of the plan's, in any direction [m/s^2].
        tilt_max: largest angle of thrust to vertical that its controllers command [rad].
    """
    for trajectory, waypoints in zip(plan.trajectories, swarm, strict=True):
        _check_thrust(trajectory, waypoints, vehicle, reserve)
        _check_fall(least_upward_thrust(trajectory), waypoints)
        _check_tilt(peak_tilt(trajectory), waypoints, tilt_max)
        _check_yaw_rate(peak_yaw_rate(trajectory), waypoints)


def _check_thrust(
    trajectory: Trajectory, waypoints: VehicleWaypoints, vehicle: Vehicle, reserve: float
) -> None:
    peak = peak_norm(trajectory, 2, np.array([0.0, 0.0, GRAVITY]))
    thrust = vehicle.mass * (peak.value + reserve)
    if thrust > vehicle.rpyt_thrust_max:
        most = f"{vehicle.name} has at most {vehicle.rpyt_thrust_max:.3g} N"
        needs = f"needs {thrust:.3g} N of thrust, but {most}; allow more time"
        raise NotFlyableError(f"{_place(waypoints, peak.t)}: {needs}")


def _check_fall(least: UpwardThrust, waypoints: VehicleWaypoints) -> None:
    if not least.is_commanded:
        raise NotFlyableError(f"{_place(waypoints, least.t)}: {least}; allow more time")


def _check_tilt(peak: Peak, waypoints: VehicleWaypoints, tilt_max: float) -> None:
    if peak.value > tilt_max * (1.0 + ROUNDING):
        tilts = f"tilts by {peak.value:.3g} rad, but controllers by at most {tilt_max:g} rad"
        raise NotFlyableError(f"{_place(waypoints, peak.t)}: {tilts}; allow more time")


def _check_yaw_rate(peak: Peak, waypoints: VehicleWaypoints) -> None:
    if peak.value > YAW_RATE_MAX * (1.0 + ROUNDING):
        turns = f"turns at {peak.value:.3g} rad/s, maximum {YAW_RATE_MAX:g} rad/s"
        yaw = "yaw is in radians and not wrapped, so 0 to 6.28 is a full turn"
        raise NotFlyableError(f"{_place(waypoints, peak.t)}: {turns}; allow more time, or turn less ({yaw})")


def _place(waypoints: VehicleWaypoints, t: float) -> str:
    """Return vehicle, waypoint and time t [s], in words."""
    after = int(np.searchsorted(waypoints.times, t, side="right")) - 1
    return f"{waypoints.name}, after waypoint {after} (t = {t:.2f} s)"
