"""Planning around learned downwash, and replanning online, take the downwash off section 4.1's crossing."""

from dataclasses import replace

import numpy as np
import pytest
from section_4_1 import SECTION_4_1

from q2q_model.downwash.interaction_model import Reach
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.downwash.level_set import level_set
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.model_files.find_model import find_model
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_model.vehicle.altitude_loop import PAPER_LOOP
from q2q_planner.offline.avoidance.joint_plan import avoid_zones
from q2q_planner.offline.avoidance.waypoint_checks import InfeasibleError
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.offline.zones.altitude_response import altitude_errors, altitude_rms
from q2q_planner.offline.zones.downwash_zone import LearnedDownwash, avoid_downwash
from q2q_planner.online.safe.safe_replanner import SafeReplanner

STEP = 0.02
HARMLESS = 0.05
"""Downwash taken as harmless [m/s^2]: a tenth of its strength at 0.5 m."""


def references(plan: SwarmPlan) -> np.ndarray:
    t = np.arange(0.0, 50.0, STEP)
    return np.stack([trajectory.at(t)[:, :3] for trajectory in plan.trajectories], axis=1)


def test_the_downwash_response_of_a_constant_push_is_the_static_error() -> None:
    class Push(NoInteraction):
        """Push every vehicle that has a neighbour by 0.1 m/s^2."""

        @property
        def reach(self) -> Reach:
            return Reach(horizontal=2.0, vertical=1.0)

        def acceleration(self, rel_pos: np.ndarray, motion: object) -> np.ndarray:  # noqa: ARG002
            return np.full(rel_pos.shape, 0.1)

    hover = np.zeros((4000, 2, 3))
    hover[:, 1, 0] = 1.0
    assert altitude_errors(hover, STEP, Push(), PAPER_LOOP)[-1] == pytest.approx(
        0.1 / PAPER_LOOP.k_p, rel=1e-3
    )


def test_the_lowest_of_a_stack_sinks_less_where_the_middle_one_absorbs() -> None:
    stack = np.tile([[0.0, 0.0, 1.0], [0.0, 0.0, 1.5], [0.0, 0.0, 2.1]], (200, 1, 1))
    plain, absorbed = (
        altitude_errors(stack, STEP, law, PAPER_LOOP)[-1, 0]
        for law in (PAPER_LAW, replace(PAPER_LAW, absorption=2.0))
    )
    assert plain < absorbed - 1e-4  # little, for the vehicles sink out of each other's jets
    assert absorbed < 0.0


def test_planning_around_the_learned_downwash_cuts_the_height_error_by_85_percent() -> None:
    free, found = minimum_snap_plan(SECTION_4_1), avoid_zones(SECTION_4_1, level_set(PAPER_LAW, HARMLESS))
    before = altitude_rms(references(free), STEP, PAPER_LAW, PAPER_LOOP)
    after = altitude_rms(references(found.plan), STEP, PAPER_LAW, PAPER_LOOP)
    assert (after <= 0.15 * before).all()
    assert found.cost <= 1.3 * found.infimum
    assert found.plan.certified


def test_the_safe_replanner_cuts_the_height_error_by_95_percent() -> None:
    plan, replanner = minimum_snap_plan(SECTION_4_1), SafeReplanner()
    ticks = [replanner.update(setpoint_at(plan, float(t)), None) for t in np.arange(0.0, 50.0, STEP)]
    moved = np.stack([tick.pos for tick in ticks])
    before = altitude_rms(references(plan), STEP, PAPER_LAW, PAPER_LOOP)
    after = altitude_rms(moved, STEP, PAPER_LAW, PAPER_LOOP)
    assert (after <= 0.05 * before).all()
    shift = np.hypot(*(moved - references(plan))[..., :2].transpose(2, 0, 1))
    assert shift.max() < 0.25  # half of the zone's width, and a little
    assert np.array_equal(ticks[-1].pos, setpoint_at(plan, ticks[-1].t).pos)


def test_where_all_height_errors_are_harmless_no_share_is_stated() -> None:
    """Of 49 mm a hundredth of a per cent is 5 micrometres: a plan that leaves 0.9 mm is good enough."""
    swarm = (
        VehicleWaypoints("cf1", (Waypoint(0, (-1, 0, 1)), Waypoint(8, (1, 0, 1)))),
        VehicleWaypoints("cf2", (Waypoint(0, (1, 0, 1.3)), Waypoint(8, (-1, 0, 1.3)))),
    )
    made = avoid_downwash(swarm, LearnedDownwash(PAPER_LAW, cut=0.9999))
    left, free = 1e3 * made.after.max(), 1e3 * made.before.max()
    assert left < 1.0 < free
    assert made.effect == (
        f"leaves a predicted height error of at most {left:.2g} mm ({free:.2g} mm without avoidance)"
    )
    alone = avoid_downwash(swarm[:1], LearnedDownwash(PAPER_LAW))
    assert alone.effect == "leaves a predicted height error of at most 0 mm (0 mm without avoidance)"


def test_a_downwash_that_no_plan_avoids_is_refused() -> None:
    """Two vehicles that stop 0.95 m above each other feel the same with and without a certified plan."""
    places = ((0.0, 0.0), (8.0, 1.5), (16.0, 3.0))
    swarm = [
        VehicleWaypoints(name, tuple(Waypoint(t, (x, 0.0, z)) for t, x in places))
        for name, z in (("cf1", 2.15), ("cf2", 1.2))
    ]
    with pytest.raises(InfeasibleError, match=r"no plan avoids 88 % of .* error: at most 0\.0 % is avoided"):
        avoid_downwash(swarm, LearnedDownwash(find_model("measured_law").interaction))
