"""The safe law leads no vehicle lower than the bound of heights, and gives way sideways instead."""

import numpy as np
import pytest
from resting_signals import resting_setpoint, resting_state
from safe_flights import BROKEN, TICK

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array, SwarmSetpoint
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions, motion_after
from q2q_planner.online.safe.stopping.jerk_limited import jerk_limited_motion_after
from q2q_planner.online.safe.stopping.rest_height import rest_height

LAWS = [SafeReplannerParams(), SafeReplannerParams(jerk_max=20.0)]
SLACK = 1e-3
"""Of heights: a motion may turn within `hold` [m]."""


def moved(
    *ways: tuple[tuple[float, float, float], tuple[float, float, float]], end: float = 8.0
) -> SwarmPlan:
    """Return vehicles that fly each from a start to an end."""
    return minimum_snap_plan(
        [
            VehicleWaypoints(f"cf{row}", (Waypoint(0.0, start), Waypoint(end, goal)))
            for row, (start, goal) in enumerate(ways)
        ]
    )


def flown(plan: SwarmPlan, params: SafeReplannerParams, duration: float = 20.0) -> list[SwarmSetpoint]:
    replanner = SafeReplanner(params)
    return [replanner.update(setpoint_at(plan, k * TICK), None) for k in range(int(duration / TICK))]


def clearance(flight: list[SwarmSetpoint], params: SafeReplannerParams) -> float:
    """Return the smallest distance of the first two vehicles to each other's zone [m]."""
    apart = np.array([tick.pos[0] - tick.pos[1] for tick in flight])
    return float(Cylinder(params.eps, params.d).signed_distance(apart).min())


@pytest.mark.parametrize("params", LAWS)
def test_one_below_another_that_descends_gives_way_sideways_above_the_bound(
    params: SafeReplannerParams,
) -> None:
    """Both end at their heights, 0.4 and 0.5 m, beside each other."""
    flight = flown(moved(((0.0, 0.0, 2.5), (0.0, 0.0, 0.4)), ((0.1, 0.0, 0.5), (0.1, 0.0, 0.5))), params)
    assert min(tick.pos[:, 2].min() for tick in flight) > params.height_min - SLACK
    assert all((tick.status != BROKEN).all() for tick in flight)
    assert clearance(flight, params) >= 2.0 * params.tracking
    np.testing.assert_allclose(flight[-1].pos[:, 2], [0.4, 0.5], atol=0.01)
    assert np.abs(flight[-1].pos[:, 0] - [0.0, 0.1]).max() < 0.25


@pytest.mark.parametrize("params", LAWS)
def test_one_that_rests_at_the_bound_holds_the_other_above_it(params: SafeReplannerParams) -> None:
    """References 0.9 m above each other keep their order: nobody wants to pass."""
    flight = flown(moved(((0.0, 0.0, 2.5), (0.0, 0.0, 1.2)), ((0.0, 0.0, 0.3), (0.0, 0.0, 0.3))), params)
    assert min(tick.pos[:, 2].min() for tick in flight) > params.height_min - SLACK
    assert all((tick.status != BROKEN).all() for tick in flight)
    assert clearance(flight, params) >= 2.0 * params.tracking


@pytest.mark.parametrize("speed", [0.2, 0.5])
def test_below_an_external_vehicle_that_does_not_stop_it_gives_way_sideways(speed: float) -> None:
    """The external vehicle descends to 0.4 m over one that hovers at 0.5 m, 0.1 m aside."""
    params = LAWS[0]
    replanner, pos, vel, outside = SafeReplanner(params), np.array([[0.0, 0.0, 0.5]]), np.zeros((1, 3)), []
    for k in range(1500):
        t = k * TICK
        z = max(0.4, 3.0 - speed * t)
        other = np.array([[0.1, 0.0, z]])
        moving = np.array([[0.0, 0.0, -speed if z > 0.4 else 0.0]])
        seen = resting_state(
            t,
            ("cf1", "cf9"),
            np.concatenate((pos, other)),
            vel=np.concatenate((vel, moving)),
            age=np.zeros(2),
        )
        answer = replanner.update(resting_setpoint(t, ("cf1",), np.array([[0.0, 0.0, 0.5]])), seen)
        pos, vel = answer.pos, answer.vel
        assert pos[0, 2] > params.height_min - SLACK
        assert answer.status[0] != BROKEN
        outside.append(Cylinder(params.eps, params.d).signed_distance(pos[0] - other[0]))
    assert min(outside) > params.tracking
    assert abs(pos[0, 2] - 0.5) < 0.01


@pytest.mark.parametrize("params", LAWS)
def test_one_that_is_led_aside_still_lands_and_takes_off_by_its_reference(
    params: SafeReplannerParams,
) -> None:
    """It lands 0.2 m beside another that hovers, in its zone: led aside, it follows its reference down."""
    down = moved(((1.0, 0.0, 1.0), (0.2, 0.0, 0.0)), ((0.0, 0.0, 0.5), (0.0, 0.0, 0.5)))
    up = moved(((0.2, 0.0, 0.0), (1.0, 0.0, 1.0)), ((0.0, 0.0, 0.5), (0.0, 0.0, 0.5)))
    landed, risen = flown(down, params), flown(up, params)
    assert abs(landed[-1].pos[0, 2]) < 0.01
    assert landed[-1].pos[0, 0] > 0.25
    for k, tick in enumerate(landed):
        asked = setpoint_at(down, k * TICK).pos[:, 2]
        assert (tick.pos[:, 2] > np.minimum(asked, params.height_min) - SLACK).all()
    np.testing.assert_allclose(risen[-1].pos[0], [1.0, 0.0, 1.0], atol=1e-9)


@pytest.mark.parametrize("jerk", [0.0, 20.0])
def test_a_motion_rests_at_the_height_to_which_it_is_flown(jerk: float) -> None:
    generator = np.random.default_rng(7)
    n = 200

    def some(size: float) -> Array:
        return generator.uniform(-size, size, (n, 3))

    pos, vel, acc = some(1.0), some(1.5), some(2.0)
    held = some(jerk) if jerk else np.zeros((n, 3))
    motions = Motions(pos, vel, acc, np.full(n, 0.02), np.zeros((n, 2)), held)
    law = BrakingLaw(0.25, 1.1, 2.0, jerk)
    if jerk:
        rest = jerk_limited_motion_after(motions, 10.0, law)[0]
    else:
        rest = motion_after(motions, 10.0, law.brake)[0]
    lowest = np.array([rest_height(motions, row, law) for row in range(n)])
    np.testing.assert_allclose(lowest, np.minimum(rest[:, 2], pos[:, 2]), atol=1e-9)
