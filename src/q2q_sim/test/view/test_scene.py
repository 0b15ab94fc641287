"""The scene shows what the signals say: poses, zones, air, forces and paths."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from resting_signals import resting_state

from q2q_model.geometry.rotations import quat_from_euler, rotate
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.values import Array, Interference, SwarmSetpoint, SwarmState, TrackStatus
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_sim.scenarios import library
from q2q_sim.view.scene import (
    BREACHED,
    CLEAR,
    COASTING,
    LOST,
    MOST_STEPS,
    SceneBuilder,
    SceneParams,
    SceneSignals,
    scene_signals,
)
from q2q_sim.view.shapes import arrow_quat

NAMES = ("cf1", "cf2")
ROUNDING = 1e-12
"""Products of numbers near 1 in double precision."""


def state(t: float, pos: Array, quat: Array | None = None, status: int = TrackStatus.TRACKED) -> SwarmState:
    n = len(pos)
    level = np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
    flags = np.full(n, status, dtype=np.uint8)
    return resting_state(t, NAMES[:n], pos, quat=level if quat is None else quat, status=flags)


def apart() -> Array:
    return np.array([[0.0, 0.0, 1.0], [1.0, 0.5, 1.5]])


def test_every_vehicle_is_drawn_where_it_is_and_as_it_leans():
    quat = quat_from_euler(np.array([0.1, 0.0]), np.array([0.0, -0.2]), np.array([1.0, 2.0]))
    scene = SceneBuilder(SceneParams()).update(SceneSignals(state(0.0, apart(), quat)))
    boxes = scene.group("vehicle")
    assert [box.points[0] for box in boxes] == [tuple(row) for row in apart().tolist()]
    assert [box.quat for box in boxes] == [tuple(row) for row in quat.tolist()]
    assert [label.text for label in scene.group("name")] == ["cf1", "cf2"]


def test_the_zone_has_the_size_of_the_cylinder_and_turns_red_when_another_is_in_it():
    builder = SceneBuilder(SceneParams())
    clear = builder.update(SceneSignals(state(0.0, apart()))).group("zone")
    assert clear[0].size == (0.2, 0.2, 2.2)  # the paper's I(0.1, 1.1): diameter and height
    assert {zone.colour for zone in clear} == {CLEAR}
    above = np.array([[0.0, 0.0, 1.0], [0.05, 0.0, 1.5]])
    assert {zone.colour for zone in builder.update(SceneSignals(state(0.1, above))).group("zone")} == {
        BREACHED
    }


def test_one_vehicle_is_in_nobodys_zone():
    scene = SceneBuilder(SceneParams()).update(SceneSignals(state(0.0, np.array([[0.0, 0.0, 1.0]]))))
    assert scene.group("zone")[0].colour == CLEAR


def test_air_falls_at_the_speed_of_the_downwash_along_the_body_of_when_it_left():
    builder = SceneBuilder(SceneParams(wake_speed=5.0, d=1.0))
    tilted = quat_from_euler(np.array([0.3]), np.array([0.0]), np.array([0.0]))
    for t, x in ((0.0, 0.0), (0.1, 0.2), (0.2, 0.4)):
        scene = builder.update(SceneSignals(state(t, np.array([[x, 0.0, 2.0]]), tilted)))
    axis = rotate(tilted[0], np.array([0.0, 0.0, 1.0]))
    expected = [np.array([0.4 - 0.2 * k, 0.0, 2.0]) - axis * 5.0 * 0.1 * k for k in range(3)]
    np.testing.assert_allclose(scene.group("wake")[0].points, expected, atol=ROUNDING)


def test_air_older_than_its_way_through_the_zone_is_gone():
    builder = SceneBuilder(SceneParams(wake_speed=5.0, d=1.0))  # 0.2 s through the zone
    for tick in range(100):
        scene = builder.update(SceneSignals(state(0.01 * tick, np.array([[0.0, 0.0, 2.0]]))))
    assert min(z for _, _, z in scene.group("wake")[0].points) >= 1.0 - ROUNDING


def test_a_force_starts_at_the_vehicle_and_is_as_long_as_the_downwash_is_strong():
    eta = np.array([[0.1, 0.0, -2.0], [0.0, 0.0, 0.001]])
    downwash = Interference(0.0, NAMES, eta, np.full((2, 3), np.nan), np.zeros(2, dtype=np.uint8))
    (arrow,) = (
        SceneBuilder(SceneParams(force_scale=0.5))
        .update(SceneSignals(state(0.0, apart()), downwash))
        .group("force")
    )
    assert arrow.row == 0  # the other's downwash is too small to be seen
    np.testing.assert_allclose(arrow.points, [[0.0, 0.0, 1.0], [0.05, 0.0, 0.0]], atol=ROUNDING)


def test_signals_are_matched_by_name_not_by_row():
    eta = np.array([[0.0, 0.0, -2.0], [0.0, 0.0, 0.0]])
    downwash = Interference(0.0, ("cf2", "cf1"), eta, np.full((2, 3), np.nan), np.zeros(2, dtype=np.uint8))
    (arrow,) = SceneBuilder(SceneParams()).update(SceneSignals(state(0.0, apart()), downwash)).group("force")
    assert arrow.row == 1


def test_the_plan_is_drawn_whole_and_passes_its_waypoints():
    scenario = library.load("table6")
    builder = SceneBuilder(SceneParams())
    builder.take_plan(minimum_snap_plan(scenario.waypoints, scenario.reading))
    lines = builder.update(SceneSignals(state(0.0, apart()))).group("plan")
    for line, vehicle in zip(lines, scenario.waypoints, strict=True):
        for waypoint in vehicle.waypoints:
            gap = np.linalg.norm(np.array(line.points) - np.array(waypoint.pos), axis=1).min()
            assert gap < ROUNDING  # way-points of this scenario lie on the drawn step of 0.1 s


def test_a_plan_that_lasts_for_ages_is_drawn_with_few_points():
    scenario, builder = library.load("table6"), SceneBuilder(SceneParams())
    plan = minimum_snap_plan(scenario.waypoints[:1], scenario.reading)
    (flown,) = plan.trajectories
    ages = replace(flown, durations=1e9 * flown.durations)
    builder.take_plan(replace(plan, trajectories=(ages,)))
    (line,) = builder.update(SceneSignals(state(0.0, apart()))).group("plan")
    assert len(line.points) == MOST_STEPS + 1
    np.testing.assert_allclose(line.points[-1], scenario.waypoints[0].waypoints[-1].pos, atol=1e-3)


def test_a_new_plan_takes_the_place_of_the_one_before_for_all_vehicles():
    scenario = library.load("table6")
    builder = SceneBuilder(SceneParams())
    for flown in (scenario.waypoints, scenario.waypoints[:1]):
        builder.take_plan(minimum_snap_plan(flown, scenario.reading))
    (line,) = builder.update(SceneSignals(state(0.0, apart()))).group("plan")
    assert line.row == 0


def test_the_path_of_the_replanner_keeps_only_the_recent_past():
    builder = SceneBuilder(SceneParams(trail_s=1.0, trail_hz=10.0))
    for tick in range(300):
        t = 0.01 * tick
        safe = synthetic_signal(SwarmSetpoint, t, NAMES)
        assert isinstance(safe, SwarmSetpoint)
        safe.pos[:, 0] = t
        scene = builder.update(SceneSignals(state(t, apart()), reference_safe=safe))
    xs = [x for x, _, _ in scene.group("replanned")[0].points]
    assert 1.99 - ROUNDING <= xs[0] <= 2.1
    assert np.all(np.diff(xs) > 0.1 - 1e-6)


def test_a_jump_back_in_time_starts_the_trails_anew():
    builder = SceneBuilder(SceneParams())
    for t in (5.0, 5.1, 0.0):
        scene = builder.update(SceneSignals(state(t, apart())))
    assert scene.group("flown") == ()


@pytest.mark.parametrize(("status", "colour"), [(TrackStatus.COASTING, COASTING), (TrackStatus.LOST, LOST)])
def test_a_vehicle_that_is_not_tracked_looks_so(status: TrackStatus, colour: tuple[float, ...]):
    scene = SceneBuilder(SceneParams()).update(SceneSignals(state(0.0, apart(), status=status)))
    assert scene.group("vehicle")[0].colour == colour


@pytest.mark.parametrize(("late", "is_drawn"), [(0.49, True), (0.51, False), (-0.51, False)])
def test_forces_and_setpoints_are_drawn_while_their_source_lives(late: float, is_drawn: bool):
    last = {
        "interference": Interference(1.0, NAMES, np.ones((2, 3)), np.zeros((2, 3)), np.zeros(2, np.uint8))
    }
    for topic in ("reference", "reference_safe"):
        last[topic] = synthetic_signal(SwarmSetpoint, 1.0, NAMES)
    seen = scene_signals(state(1.0 + late, apart()), last)
    assert [one is not None for one in (seen.interference, seen.reference, seen.reference_safe)] == (
        [is_drawn] * 3
    )


def test_the_path_of_a_replanner_that_has_ended_fades():
    builder = SceneBuilder(SceneParams(trail_s=1.0, trail_hz=10.0))
    for tick in range(250):
        t = 0.01 * tick
        safe = synthetic_signal(SwarmSetpoint, t, NAMES) if t < 1.0 else None
        scene = builder.update(SceneSignals(state(t, apart()), reference_safe=safe))
        assert bool(scene.group("replanned")) == (0.095 < t < 1.805)  # two points at least


def test_what_is_not_a_number_is_not_in_the_scene():
    quat = np.tile([0.0, 0.0, 0.0, 1.0], (2, 1))
    quat[0] = np.nan
    builder = SceneBuilder(SceneParams())
    for t in (0.0, 0.1):
        safe = synthetic_signal(SwarmSetpoint, t, NAMES)
        safe.pos[:] = np.nan
        scene = builder.update(SceneSignals(state(t, apart(), quat), reference_safe=safe))
    assert scene.group("vehicle")[0].quat == (0.0, 0.0, 0.0, 1.0)
    numbers = [[*shape.quat, *np.ravel(shape.points)] for shape in scene.shapes]
    assert all(np.isfinite(one).all() for one in numbers)


def test_a_vehicle_that_is_nowhere_is_not_drawn():
    pos = apart()
    pos[0] = np.nan
    scene = SceneBuilder(SceneParams()).update(SceneSignals(state(0.0, pos)))
    assert {shape.row for shape in scene.shapes} == {1}


@example((-1.0, 0.0, 4.489013483670516e-08))
@given(st.tuples(*[st.floats(-5.0, 5.0)] * 3).filter(lambda d: math.hypot(*d) > 1e-3))
def test_an_arrow_points_from_tail_to_tip(direction: tuple[float, float, float]):
    x, y, z = direction
    turned = rotate(
        np.array(arrow_quat((1.0, 2.0, 3.0), (1.0 + x, 2.0 + y, 3.0 + z))), np.array([1.0, 0.0, 0.0])
    )
    # A tail at 1 to 3 m leaves its direction known to some 1e-15 / 1e-3.
    np.testing.assert_allclose(turned, np.array(direction) / math.hypot(*direction), atol=1e-9)
