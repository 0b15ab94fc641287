"""Vehicles that want to pass each other vertically go around each other; others are not led aside."""

import numpy as np
import pytest
from safe_flights import BROKEN, TICK

from q2q_model.geometry.zone import Cylinder
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner

LAWS = [SafeReplannerParams(), SafeReplannerParams(jerk_max=20.0)]
Height = tuple[float, float]
"""At the start and the end of a way [m]."""


def above_each_other(first: Height, second: Height, aside: float) -> SwarmPlan:
    """Return two vehicles that fly vertically within 8 s, `aside` apart."""
    return minimum_snap_plan(
        [
            VehicleWaypoints(name, (Waypoint(0.0, (x, 0.0, z[0])), Waypoint(8.0, (x, 0.0, z[1]))))
            for name, x, z in (("cf1", 0.0, first), ("cf2", aside, second))
        ]
    )


@pytest.mark.parametrize("params", LAWS)
@pytest.mark.parametrize("aside", [0.0, 0.01, 0.2, 0.3])
@pytest.mark.parametrize(
    ("first", "second"), [((0.5, 3.5), (3.5, 0.5)), ((0.5, 3.5), (2.0, 2.0)), ((4.5, 0.5), (2.0, 2.0))]
)
def test_vehicles_pass_each_other_vertically_outside_their_zones_and_end_at_their_goals(
    first: Height, second: Height, aside: float, params: SafeReplannerParams
) -> None:
    plan, replanner = above_each_other(first, second, aside), SafeReplanner(params)
    flight = [replanner.update(setpoint_at(plan, k * TICK), None) for k in range(1600)]
    apart = np.array([tick.pos[0] - tick.pos[1] for tick in flight])
    assert Cylinder(params.eps, params.d).signed_distance(apart).min() >= 2.0 * params.tracking
    assert all((tick.status != BROKEN).all() for tick in flight)
    assert np.array_equal(flight[-1].pos, setpoint_at(plan, flight[-1].t).pos)


@pytest.mark.parametrize("params", LAWS)
@pytest.mark.parametrize("aside", [0.0, 0.2])
def test_who_wants_nearer_above_another_but_not_past_it_is_not_led_aside(
    aside: float, params: SafeReplannerParams
) -> None:
    """It ends 0.6 m above the other by its reference, and waits above the zone."""
    plan, replanner = above_each_other((3.0, 1.6), (1.0, 1.0), aside), SafeReplanner(params)
    flight = [replanner.update(setpoint_at(plan, k * TICK), None) for k in range(1600)]
    flat = np.array([tick.pos[:, :2] - setpoint_at(plan, tick.t).pos[:, :2] for tick in flight])
    assert np.abs(flat).max() < 1e-9
    assert flight[-1].pos[0, 2] - flight[-1].pos[1, 2] > params.d
