"""The safe law keeps its promise wherever its conditions hold, and says so wherever it cannot."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_flights import BROKEN, PARAMS, TICK, ZONE, seen, swap

from q2q_model.signals.values import Array, SetpointStatus, SwarmSetpoint
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.safe_replanner import SafeReplanner


def encounter(seed: int, most: int = 10) -> SwarmPlan:
    """Return 2 to `most` vehicles that fly at random through a small room, at up to 2 m/s."""
    generator = np.random.default_rng(seed)
    n, side, end = generator.integers(2, most + 1), generator.uniform(1.5, 4.0), generator.uniform(4.0, 8.0)
    box = np.array([side / 2, side / 2, 0.6])
    points = generator.uniform(-1.0, 1.0, (n, 2, 3)) * box + [0.0, 0.0, 1.2]
    return minimum_snap_plan(
        [
            VehicleWaypoints(f"cf{row}", (Waypoint(0.0, tuple(a)), Waypoint(float(end), tuple(b))))
            for row, (a, b) in enumerate(points)
        ]
    )


def together(plan: SwarmPlan, duration: float, params: SafeReplannerParams = PARAMS) -> list[SwarmSetpoint]:
    """Fly all vehicles under one replanner."""
    replanner = SafeReplanner(params)
    return [replanner.update(setpoint_at(plan, k * TICK), None) for k in range(int(duration / TICK))]


def judged(flown: list[SwarmSetpoint]) -> tuple[Array, Array, Array]:
    """Return for each tick and pair: inside the zone, announced by both; and who was ever broken (T, n)."""
    pos, broken = np.array([tick.pos for tick in flown]), np.array([tick.status == BROKEN for tick in flown])
    i, j = np.triu_indices(pos.shape[1], 1)
    inside = ZONE.signed_distance(pos[:, i] - pos[:, j]) < 0.0
    return inside, broken[:, i] & broken[:, j], broken


def assert_no_jump(flown: list[SwarmSetpoint]) -> None:
    """Ticks hang together: no jump of position or velocity that acc_max does not explain, but snapping."""
    pos, vel = np.array([tick.pos for tick in flown]), np.array([tick.vel for tick in flown])
    ends = pos[:-1] + 0.5 * TICK * (vel[1:] + vel[:-1])
    slack = 0.5 * PARAMS.acc_max * TICK**2 + 1e-4 + 5e-3 * TICK  # turning within a tick, and SNAP_*
    assert np.abs(pos[1:] - ends).max() < slack
    assert np.sqrt(((vel[1:] - vel[:-1]) ** 2).sum(-1)).max() < PARAMS.acc_max * TICK + 5e-3
    acc = np.array([tick.acc for tick in flown])
    assert np.sqrt((acc**2).sum(-1)).max() <= PARAMS.acc_max * (1.0 + 1e-12)


@settings(deadline=None, max_examples=4)
@given(st.integers(0, 10**6))
def test_the_modified_trajectory_moves_as_its_acceleration_says(seed: int) -> None:
    assert_no_jump(together(encounter(seed, most=4), 5.0))


@settings(deadline=None, max_examples=4)
@given(st.integers(0, 10**6), st.lists(st.integers(1, 699), min_size=1, max_size=6, unique=True))
def test_switching_on_and_off_in_flight_never_jumps_and_ends_on_the_original(
    seed: int, switches: list[int]
) -> None:
    """Every switch is flown within the limits, from wherever the last one left the vehicles."""
    plan, replanner, enabled, flown = encounter(seed, most=3), SafeReplanner(PARAMS), True, []
    for k in range(1800):
        if k in switches:
            enabled = not enabled
            replanner.configure(replace(PARAMS, enabled=enabled))
        if k == 1000:  # whatever was chosen: off at last
            replanner.configure(replace(PARAMS, enabled=False))
        flown.append(replanner.update(setpoint_at(plan, k * TICK), None))
    assert_no_jump(flown)
    assert np.array_equal(flown[-1].pos, setpoint_at(plan, flown[-1].t).pos)


def test_an_exact_head_on_swap_is_resolved_to_the_right_and_ends_on_the_reference() -> None:
    flown = together(swap(), 14.0)
    inside, _, broken = judged(flown)
    assert not inside.any()
    assert not broken.any()
    passing = max(flown, key=lambda tick: np.abs(tick.pos[:, 1]).min())
    assert passing.pos[0, 1] < -0.05  # cf1 flies east: its right is south
    assert passing.pos[1, 1] > 0.05
    last = setpoint_at(swap(), flown[-1].t)
    assert np.array_equal(flown[-1].pos, last.pos)
    assert (flown[-1].status == SetpointStatus.NOMINAL).all()
    assert SetpointStatus.SHIFTED in passing.status


def test_vehicles_far_apart_fly_the_reference_to_the_last_bit() -> None:
    plan = minimum_snap_plan(
        [
            VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(3, (1, 0, 1)))),
            VehicleWaypoints("cf2", (Waypoint(0, (0, 30, 1)), Waypoint(3, (1, 30, 1)))),
        ]
    )
    replanner = SafeReplanner(PARAMS)
    for k in (0, 1, 2, 3, 50, 51, 150, 250):  # gaps too
        reference = setpoint_at(plan, k * TICK)
        assert replanner.update(reference, seen(reference)) is reference


def test_switched_off_it_passes_the_reference_or_leads_back_to_it() -> None:
    off = SafeReplanner(replace(PARAMS, enabled=False))
    for k in range(600):
        reference = setpoint_at(swap(), k * TICK)
        assert off.update(reference, None) is reference
    replanner, ticks = SafeReplanner(PARAMS), []
    for k in range(1500):
        if k == 300:
            replanner.configure(replace(PARAMS, enabled=False))
        ticks.append(replanner.update(setpoint_at(swap(), k * TICK), None))
    assert np.array_equal(ticks[-1].pos, setpoint_at(swap(), ticks[-1].t).pos)
    jump = np.abs(ticks[301].pos - ticks[300].pos).max()
    assert jump < 0.02  # 2 m/s


def test_a_repeated_stamp_gets_the_same_answer_and_lost_ticks_break_nothing() -> None:
    replanner, plan = SafeReplanner(PARAMS), swap()
    lost = set(range(255, 275)) | set(range(280, 310, 2))
    flown = []
    for k in range(900):
        if k in lost:
            continue
        answer = replanner.update(setpoint_at(plan, k * TICK), None)
        assert replanner.update(setpoint_at(plan, k * TICK), None) is answer
        flown.append(answer)
    inside, _, broken = judged(flown)
    assert not inside.any()
    assert not broken.any()


def test_late_frames_and_a_clock_set_back_move_no_shifted_setpoint() -> None:
    for back in (2, 40):  # late by two ticks, a clock set back by 0.4 s
        replanner, plan = SafeReplanner(PARAMS), swap()
        before = [replanner.update(setpoint_at(plan, k * TICK), None) for k in range(300)][-1]
        assert np.abs(before.pos - setpoint_at(plan, before.t).pos).max() > 0.1  # shifted aside
        after = [replanner.update(setpoint_at(plan, (300 - back + k) * TICK), None) for k in range(600)]
        steps = np.linalg.norm(np.diff([before.pos, *(tick.pos for tick in after)], axis=0), axis=-1)
        assert np.delete(steps, 10, axis=0).max() < 0.02  # 2 m/s
        assert steps[10].max() < 0.02 * 10  # by then a clock is known to be set back, and 0.1 s has passed
        inside, _, broken = judged(after)
        assert not inside.any()
        assert not broken.any()


def test_motions_go_on_through_a_clock_set_back_as_through_lost_ticks() -> None:
    """From the first of its stamps on; what is flown meanwhile is held."""
    plan, lost, jumped = swap(), SafeReplanner(PARAMS), SafeReplanner(PARAMS)
    for k in range(600):
        reference = setpoint_at(plan, k * TICK)
        answer = jumped.update(replace(reference, t=(k - 41 if k >= 300 else k) * TICK), None)
        if k < 300:
            held = lost.update(reference, None)
        elif k >= 310:
            expected = lost.update(replace(reference, t=(k - 1) * TICK), None)
            np.testing.assert_allclose(answer.pos, expected.pos, atol=1e-9)
            assert answer.status.tolist() == expected.status.tolist()
        else:
            assert np.array_equal(answer.pos, held.pos)


@pytest.mark.parametrize("late", [(100,), (140, 110), tuple(range(80, 90))])
def test_late_frames_change_nothing_of_the_ticks_after_them(late: tuple[int, ...]) -> None:
    plan, calm, disturbed = swap(), SafeReplanner(PARAMS), SafeReplanner(PARAMS)
    for k in range(600):
        if k == 300:
            for old in late:
                assert disturbed.update(setpoint_at(plan, old * TICK), None).t == old * TICK
        expected = calm.update(setpoint_at(plan, k * TICK), None)
        assert np.array_equal(disturbed.update(setpoint_at(plan, k * TICK), None).pos, expected.pos)


def test_vehicles_that_start_inside_each_others_zone_say_so_and_part() -> None:
    close = minimum_snap_plan(
        [
            VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(3, (-1, 0, 1)))),
            VehicleWaypoints("cf2", (Waypoint(0, (0.1, 0, 1)), Waypoint(3, (1, 0, 1)))),
        ]
    )
    flown = together(close, 3.0)
    assert (flown[0].status == BROKEN).all()
    assert (flown[-1].status != BROKEN).all()
    inside, announced, _ = judged(flown)
    assert not (inside & ~announced).any()


def test_a_vehicle_that_leaves_its_trajectory_or_is_lost_is_announced() -> None:
    replanner, plan = SafeReplanner(PARAMS), swap()
    for k in range(10):
        reference = setpoint_at(plan, k * TICK)
        assert (replanner.update(reference, seen(reference)).status != BROKEN).all()
    reference = setpoint_at(plan, 0.10)
    strayed = replace(seen(reference), pos=reference.pos + np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.0]]))
    assert (replanner.update(reference, strayed).status == [BROKEN, SetpointStatus.NOMINAL]).all()


def test_a_number_out_of_bounds_is_named() -> None:
    with pytest.raises(
        ValueError, match=r"SafeReplannerParams.acc_max = 0.0; must be in \[0.1, 50.0\] m/s\^2"
    ):
        SafeReplannerParams(acc_max=0.0)


def test_side_by_side_outside_the_zone_the_reference_is_flown_to_the_last_bit() -> None:
    """They keep 0.1 m more apart than the zone, what they may be off, and the margin ask."""
    apart = PARAMS.eps + 2.0 * PARAMS.tracking + PARAMS.margin + 0.1
    plan = minimum_snap_plan(
        [
            VehicleWaypoints("cf1", (Waypoint(0, (0, 0, 1)), Waypoint(3, (2, 0, 1)))),
            VehicleWaypoints("cf2", (Waypoint(0, (0, apart, 1)), Waypoint(3, (2, apart, 1)))),
        ]
    )
    replanner = SafeReplanner(PARAMS)
    for k in range(300):
        reference = setpoint_at(plan, k * TICK)
        assert replanner.update(reference, None) is reference
