"""Transit of vehicles: certified plan from rest at some points to rest at others.

All vehicles move at once on straight lines if the certificate holds; else one after another, each on a
straight line or by a waypoint beside its middle, in the first order in which every vehicle has a certified
path.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise, permutations
from math import sqrt

import numpy as np

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array, Names
from q2q_model.trajectory.polynomials import SwarmPlan, Trajectory
from q2q_model.tunable import check_bounds, tunable
from q2q_planner.offline.certificate.certificate import Certificate, certify
from q2q_planner.offline.minimum_snap.flight_limits import PEAK_ACC, PEAK_SPEED, PEAK_YAW_RATE, FlightLimits
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import waypoints_through

ORDERS = 24
"""Most orders that are tried: all of four vehicles."""
TURN_MAX = 1.5
"""Largest yaw rate of a transit [rad/s], less than half of what controllers may command."""
ACC_MAX = FlightLimits().acceleration
"""Largest acceleration of a transit [m/s^2], as of allocated times."""
ASIDE = (0.0, 0.5, -0.5, 1.0, -1.0)
"""Offsets of the waypoint beside the middle of a line, tried in this order [m]."""


@dataclass(frozen=True, slots=True)
class TransitParams:
    """Speed and zone of a transit."""

    transit_speed: float = tunable(
        0.5, "largest speed of the transit to the plan's first points", unit="m/s", low=0.05, high=5.0
    )
    transit_duration_min: float = tunable(
        1.0, "minimum duration of a vehicle's transit", unit="s", low=0.1, high=60.0
    )
    transit_eps: float = tunable(
        0.2,
        "radius of the cylinder around each vehicle that a transit keeps free of other vehicles",
        unit="m",
        low=0.01,
        high=5.0,
    )
    transit_d: float = tunable(
        Cylinder().d,
        "half height of the cylinder around each vehicle that a transit keeps free of other vehicles",
        unit="m",
        low=0.01,
        high=10.0,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)

    @property
    def zone(self) -> Cylinder:
        """Return what a transit keeps free of other vehicles."""
        return Cylinder(self.transit_eps, self.transit_d)


def transit_plan(names: Names, here: Array, there: Array, params: TransitParams) -> SwarmPlan:
    """Return the certified plan from points `here` to points `there`, (n, 4): x, y, z [m], yaw [rad].

    Raises:
        ValueError: no order keeps the vehicles apart; names the pair and its distance.
    """
    here = here.copy()
    here[:, 3] = there[:, 3] + wrap_angles(here[:, 3] - there[:, 3])  # the short way round
    together = _together(names, here, there, params)
    proof = certify(together, params.zone)
    if proof.holds:
        return replace(together, certified=True)
    for order in islice(permutations(np.argsort(-here[:, 2], kind="stable").tolist()), ORDERS):
        legs = _one_by_one(names, here, there, params, order)
        if legs is not None:
            return replace(_joined(names, legs), certified=True)
    raise ValueError(_refusal(proof, params.zone))


def wrap_angles(angle: Array) -> Array:
    """Return angles (...,) [rad] from -pi to pi."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


def _together(names: Names, here: Array, there: Array, params: TransitParams) -> SwarmPlan:
    duration = max(_duration(start, end, params) for start, end in zip(here, there, strict=True))
    rows = zip(names, here, there, strict=True)
    return minimum_snap_plan(
        [waypoints_through(name, (0.0, duration), (start, end)) for name, start, end in rows]
    )


def _one_by_one(
    names: Names, here: Array, there: Array, params: TransitParams, order: tuple[int, ...]
) -> list[SwarmPlan] | None:
    """Return a certified plan for each vehicle's turn, the others at rest; None if one has no path."""
    now, legs = here.copy(), []
    for row in order:
        paths = (_path(now[row], there[row], aside) for aside in ASIDE)
        candidates = (_turn(names, now, row, path, params) for path in paths)
        leg = next((plan for plan in candidates if certify(plan, params.zone, enough=0.0).holds), None)
        if leg is None:
            return None
        legs.append(leg)
        now[row] = there[row]
    return legs


def _path(start: Array, end: Array, aside: float) -> list[Array]:
    """Return the points of a path, (4,) each, whose middle is offset by `aside` [m] unless it is vertical."""
    across = np.array([start[1] - end[1], end[0] - start[0], 0.0, 0.0])
    length = float(np.hypot(across[0], across[1]))
    if aside == 0.0 or length == 0.0:
        return [start, end]
    return [start, 0.5 * (start + end) + aside * across / length, end]


def _turn(names: Names, now: Array, mover: int, points: list[Array], params: TransitParams) -> SwarmPlan:
    """Return the plan that moves one vehicle along points, the others at rest."""
    times = np.cumsum([0.0, *(_duration(one, other, params) for one, other in pairwise(points))])
    candidates = [
        waypoints_through(name, times, points)
        if row == mover
        else waypoints_through(name, (0.0, times[-1]), [now[row]] * 2)
        for row, name in enumerate(names)
    ]
    return minimum_snap_plan(candidates)


def _joined(names: Names, legs: Sequence[SwarmPlan]) -> SwarmPlan:
    """Return the plan that flies some plans of the same vehicles one after another."""
    curves = tuple(
        Trajectory(
            np.concatenate([leg.trajectories[row].durations for leg in legs]),
            np.concatenate([leg.trajectories[row].coefficients for leg in legs]),
        )
        for row in range(len(names))
    )
    return SwarmPlan(names, curves)


def _duration(here: Array, there: Array, params: TransitParams) -> float:
    length = float(np.linalg.norm(there[:3] - here[:3]))
    turn = abs(float(there[3] - here[3]))
    travel = max(PEAK_SPEED * length / params.transit_speed, sqrt(PEAK_ACC * length / ACC_MAX))
    return max(travel, PEAK_YAW_RATE * turn / TURN_MAX, params.transit_duration_min)


def _refusal(proof: Certificate, zone: Cylinder) -> str:
    if proof.not_computed:
        return f"no transit is proven: {proof.not_computed}"
    pair = " and ".join(proof.pair or ())
    near = f"{pair} would enter each other's zone by {-proof.clearance:.2f} m at {proof.t:.1f} s"
    return f"{near} (radius {zone.eps:.2f} m, half height {zone.d:.2f} m), in every order"
