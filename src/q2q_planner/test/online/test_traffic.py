"""What the safe law takes for granted of everybody at a tick: closed forms, and both sides of every bound."""

from dataclasses import replace

import numpy as np
import pytest
from traffic_bench import ON, PARAMS, held, setpoint, state

from q2q_model.signals.values import SwarmSetpoint
from q2q_planner.online.last_known_states import KnownStates, LastKnownStates
from q2q_planner.online.replanner import LONGEST_GAP
from q2q_planner.online.safe.motion.committed_motion import MotionRows, still_flown
from q2q_planner.online.safe.motion.followed_reference import SNAP_POS, SNAP_VEL, near_rows, reference_rows
from q2q_planner.online.safe.motion.motion_propagation import propagate
from q2q_planner.online.safe.motion.traffic import TrafficTable, limits_of, traffic_at
from q2q_planner.online.safe.tracking_uncertainty import off_trajectory, own_uncertainty


def test_the_newest_state_of_a_vehicle_counts_by_the_time_it_was_measured() -> None:
    seen = LastKnownStates()
    seen.update(state(1.0, ("a", "b"), [1.0, 2.0], age=0.25))
    seen.update(state(1.125, ("a",), [9.0], age=0.5))  # heard later, measured before
    seen.update(state(1.125, ("a",), [8.0], age=0.375))  # measured at the same time: no news
    states = seen.of(("b", "a", "c"), 2.0)
    assert states.pos[:2, 0].tolist() == [2.0, 1.0]
    assert states.vel[:2].tolist() == [[0.0, 1.0, 0.0]] * 2
    assert states.age.tolist() == [1.25, 1.25, np.inf]
    assert np.isnan(states.pos[2]).all()
    assert np.isnan(states.vel[2]).all()
    seen.update(state(1.25, ("a",), [3.0]))
    states = seen.of(("a",), 1.0)  # by a clock that is behind: not younger than now
    assert (states.pos[0, 0], states.age[0]) == (3.0, 0.0)
    seen.reset()
    assert seen.external((), 1.25).names == ()


@pytest.mark.parametrize("back", [0.4, 100.0])
def test_after_a_clock_was_set_back_states_are_as_old_as_before_and_the_next_ones_count(back: float) -> None:
    seen = LastKnownStates()
    seen.update(state(200.0, ("silent", "a"), [5.0, 1.0], age=0.25))
    seen.update(state(200.5, ("a",), [1.5], age=0.125))
    seen.set_back(back)
    seen.update(state(200.5 - back, ("a",), [2.0], age=0.0))  # measured since
    states = seen.of(("a", "silent"), 200.5 - back)
    assert states.pos[:, 0].tolist() == [2.0, 5.0]
    np.testing.assert_allclose(states.age, [0.0, 0.75], atol=1e-12)
    seen.update(state(200.51 - back, ("a",), [2.01]))
    states = seen.of(("a", "silent"), 200.51 - back)
    assert states.pos[:, 0].tolist() == [2.01, 5.0]
    np.testing.assert_allclose(states.age, [0.0, 0.76], atol=1e-12)
    assert seen.forget(200.51 - back, 0.75) == ("silent",)
    assert seen.external((), 200.51 - back).names == ("a",)


@pytest.mark.parametrize("part", ["pos", "vel", "age"])
def test_a_row_that_is_no_number_says_nothing(part: str) -> None:
    seen = LastKnownStates()
    broken = state(1.0, ("a", "b"), [1.0, 2.0])
    getattr(broken, part)[0] = np.nan
    seen.update(broken)
    assert seen.external((), 1.0).names == ("a", "b")
    assert seen.forget(1.0, 1.0) == ()  # one that was never measured is not missed
    assert seen.external((), 1.0).names == ("b",)
    assert seen.of(("a",), 1.0).age.tolist() == [np.inf]


def test_external_vehicles_are_those_of_no_swarm_until_they_are_forgotten_for_good() -> None:
    seen = LastKnownStates()
    seen.update(state(1.0, ("a", "b"), [1.0, 2.0]))
    assert seen.forget(3.0, 2.0) == ()
    assert seen.external(("a",), 3.0).names == ("b",)
    assert seen.external(("a", "b"), 3.0).names == ()
    assert seen.forget(3.0, 1.999) == ("a", "b")
    assert seen.external((), 1.0).names == ()


def test_a_motion_is_carried_on_by_its_acceleration_and_then_brakes() -> None:
    pos, vel, acc = np.array([[1.0, 2.0, 3.0]] * 2), np.array([[0.0, 1.0, 0.0]] * 2), np.eye(3)[:2] * 2.0
    motion = held(pos, vel, 0.5, acc)
    motion = motion.with_rows(motion.rows._replace(on_reference=ON, pushed=ON))
    there = setpoint(1.25, ("a", "b"), np.zeros((2, 3)))
    strong = replace(PARAMS, acc_max=4.0)
    moved = propagate(motion, there, strong)
    early = moved.rows
    np.testing.assert_allclose(early.pos[0], [1.0 + 0.0625, 2.25, 3.0], atol=1e-15)
    np.testing.assert_allclose(early.vel[0], [0.5, 1.0, 0.0], atol=1e-15)
    assert early.hold.tolist() == [0.25, 0.25]
    assert (moved.t, early.acc.tolist()) == (1.25, acc.tolist())
    assert early.on_reference.all()
    assert early.pushed.all()
    # b along y at 2 m/s after its hold, then a quarter
    late = propagate(motion, replace(there, t=1.75), strong).rows
    np.testing.assert_allclose(late.pos[1], [1.0, 2.0 + 0.75 + 0.5 - 0.125, 3.0], atol=1e-15)
    np.testing.assert_allclose(late.vel[1], [0.0, 1.0, 0.0], atol=1e-15)
    assert late.hold.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("passed", "carried"),
    [(0.0, True), (-LONGEST_GAP, True), (LONGEST_GAP, True), (LONGEST_GAP + 0.5, False), (-5.5, False)],
)
def test_who_is_silent_for_too_long_starts_on_the_reference(passed: float, *, carried: bool) -> None:
    motion = held(np.ones((2, 3)), np.zeros((2, 3)))
    there = setpoint(1.0 + passed, ("a", "b"), np.zeros((2, 3)), np.ones((2, 3)))
    moved = propagate(still_flown(motion, there.t), there, PARAMS)
    after = moved.rows
    assert moved.t == 1.0 + passed
    assert (after.pos == 1.0).all() == carried
    assert (after.vel == 0.0).all() == carried
    assert after.on_reference.tolist() == [not carried] * 2
    assert not after.pushed.any()
    assert not after.acc.any()
    assert not after.hold.any()


def test_motions_follow_vehicles_by_name_and_new_ones_start_on_their_references() -> None:
    motion = held(np.array([[1.0] * 3, [2.0] * 3]), np.zeros((2, 3)), 0.5, np.eye(3)[:2] * 2.0)
    motion = motion.with_rows(motion.rows._replace(pushed=np.array([False, True])))
    moved = propagate(motion, setpoint(1.25, ("b", "new"), np.zeros((2, 3)), np.ones((2, 3))), PARAMS)
    after = moved.rows
    assert moved.names == ("b", "new")
    assert after.pos.tolist() == [[2.0, 2.0625, 2.0], [0.0, 0.0, 0.0]]
    assert after.vel.tolist() == [[0.0, 0.5, 0.0], [1.0, 1.0, 1.0]]
    assert after.acc.tolist() == [[0.0, 2.0, 0.0], [0.0, 0.0, 0.0]]
    assert after.hold.tolist() == [0.25, 0.0]
    assert after.on_reference.tolist() == [False, True]
    assert after.pushed.tolist() == [True, False]
    mixed = motion.with_rows(motion.rows._replace(on_reference=np.array([True, False])))
    more = setpoint(1.25, ("b", "a", "new"), np.zeros((3, 3)))
    assert propagate(mixed, more, PARAMS).rows.on_reference.tolist() == [False, True, True]


def near(rows: MotionRows, reference: SwarmSetpoint) -> list[bool]:
    """Return which vehicles may be put onto a reference."""
    return near_rows(rows, reference_rows(reference)).tolist()


def test_who_is_near_its_reference_and_was_not_pushed_may_be_put_onto_it() -> None:
    zero = np.zeros((2, 3))
    aside, away = np.array([[0.6, 0.8, 0.0], [0.6, 0.8, 0.0]]), np.array([[0.99], [1.01]])
    reference = setpoint(1.0, ("a", "b"), zero)
    assert near(held(SNAP_POS * away * aside, zero).rows, reference) == [True, False]
    assert near(held(zero, SNAP_VEL * away * aside).rows, reference) == [True, False]
    there = held(zero, zero).rows
    assert near(there, setpoint(1.0, ("a", "b"), aside)) == [False, False]
    assert near(there, setpoint(1.0, ("a", "b"), zero, aside)) == [False, False]
    assert near(there._replace(pushed=np.array([True, False])), reference) == [False, True]


def states(ages: list[float], x: list[float], speed: float = 1.0) -> KnownStates:
    """Return states of vehicles at x [m] that flew along y, so old [s]."""
    pos, vel = np.zeros((len(ages), 3)), np.zeros((len(ages), 3))
    pos[:, 0], vel[:, 1] = x, speed
    return KnownStates(tuple("pqrs"[: len(ages)]), pos, vel, np.array(ages))


def test_the_uncertainty_of_the_swarm_grows_with_the_time_that_a_measurement_is_missing() -> None:
    motion = held(np.zeros((2, 3)), np.zeros((2, 3)))
    sure, grace = [PARAMS.tracking + SNAP_POS, SNAP_VEL], PARAMS.grace
    assert own_uncertainty(motion, None, PARAMS).tolist() == [sure, sure]
    assert own_uncertainty(motion, states([0.0, grace], [0.0, 0.0]), PARAMS).tolist() == [sure, sure]
    some = own_uncertainty(motion, states([grace + 0.5, np.inf], [0.0, 0.0]), PARAMS)
    drifted = PARAMS.drift * np.array([0.5, PARAMS.forget - grace])
    np.testing.assert_allclose(some[:, 0], PARAMS.tracking + SNAP_POS + drifted, rtol=1e-15)
    np.testing.assert_allclose(some[:, 1], SNAP_VEL + PARAMS.drift, rtol=1e-15)
    covered = replace(PARAMS, grace=grace + 0.5)  # a tube from flights with gaps as long
    assert own_uncertainty(motion, states([0.0, grace + 0.5], [0.0, 0.0]), covered).tolist() == [sure, sure]


def test_who_is_further_off_than_its_age_explains_is_off_its_trajectory() -> None:
    age = 0.5
    bound = PARAMS.tracking + PARAMS.drift * age + 0.5 * PARAMS.acc_max * age**2
    off = states([age, age], [0.6 * (bound - 1e-9), 0.6 * (bound + 1e-9)])
    off.pos[:, 2] = off.pos[:, 0] * 4.0 / 3.0
    motion = held(np.tile([0.0, 0.5, 0.0], (2, 1)), np.zeros((2, 3)))  # where 1 m/s lead
    assert off_trajectory(motion, off, PARAMS).tolist() == [False, True]
    assert off_trajectory(motion, None, PARAMS).tolist() == [False, False]
    silent = states([np.inf, np.inf], [0.0, 100.0])
    assert off_trajectory(motion, silent, PARAMS).tolist() == [
        False,
        True,
    ]  # as old as is remembered, no older


@pytest.mark.parametrize(("age", "since"), [(0.0, 0.0), (0.5, 0.2 * 0.5 + 0.5 * 3.0 * 0.5**2)])
def test_a_tube_has_a_radius_and_a_height_of_its_own_and_both_grow_with_age(age: float, since: float) -> None:
    tube = replace(PARAMS, tracking=0.05, tracking_z=0.1)
    motion = held(np.tile([0.0, age, 0.0], (2, 1)), np.zeros((2, 3)))  # where 1 m/s lead
    off = np.array([-1e-9, 1e-9])  # inside, outside
    aside = states([age, age], [0.0, 0.0])
    aside.pos[:, 0], aside.pos[:, 1] = 0.6 * (0.05 + since + off), 0.8 * (0.05 + since + off)
    assert off_trajectory(motion, aside, tube).tolist() == [False, True]
    above = states([age, age], [0.0, 0.0])
    above.pos[:, 2] = -(0.1 + since + off)
    assert off_trajectory(motion, above, tube).tolist() == [False, True]


def among_external_vehicles(strange: KnownStates) -> TrafficTable:
    """Return the table of two vehicles at rest and external vehicles."""
    pos = np.array([[0.0, 0.0, 0.0], [0.0, 90.0, 0.0]])
    growth = np.zeros((2, 2))
    reference = reference_rows(setpoint(1.0, ("a", "b"), pos + 1.0))
    return traffic_at(held(pos, np.zeros((2, 3))), reference, growth, strange, PARAMS)[1]


def test_what_an_external_vehicle_may_have_done_since_its_state_grows_its_zone() -> None:
    traffic = among_external_vehicles(states([0.0, 0.3, 2.5], [1.0, 2.0, 3.0]))
    assert traffic.own == 2
    np.testing.assert_allclose(
        traffic.rows.pos[2:], [[1.0, 0.0, 0.0], [2.0, 0.3, 0.0], [3.0, 2.5, 0.0]], atol=1e-15
    )
    assert traffic.rows.vel[2:].tolist() == [[0.0, 1.0, 0.0]] * 3
    turned = np.array([0.5 * 3.0 * 0.02**2, 0.5 * 3.0 * 0.32**2, 3.0 * 2.52])  # the last: 2 m/s against 1
    np.testing.assert_allclose(traffic.rows.growth[2:, 0], turned + SNAP_POS + PARAMS.tracking, rtol=1e-14)
    np.testing.assert_allclose(traffic.rows.growth[2:, 1], np.array([0.06, 0.96, 3.0]) + SNAP_VEL, rtol=1e-14)


def test_an_external_vehicle_that_keeps_the_law_certainly_brakes_from_its_hold_on() -> None:
    pos, vel, acc, hold, growth, _ = among_external_vehicles(
        states([0.0, 0.005, 0.3], [1.0, 2.0, 3.0])
    ).certain
    np.testing.assert_allclose(pos[:, 1], [0.0, 0.005, 0.02 + 0.28 - 1.5 * 0.28**2], atol=1e-15)
    np.testing.assert_allclose(vel[:, 1], [1.0, 1.0, 1.0 - 3.0 * 0.28], atol=1e-15)
    np.testing.assert_allclose(hold, [0.02, 0.015, 0.0], atol=1e-15)
    assert pos[:, 0].tolist() == [1.0, 2.0, 3.0]
    assert not acc.any()
    rest = 1.0 / 3.0  # of 1 m/s
    slack = PARAMS.tracking - 1.5 * 0.02**2 - 3.0 * 0.02 * rest - SNAP_POS - SNAP_VEL * rest
    np.testing.assert_allclose(growth, [[slack, 0.0]] * 3, rtol=1e-12)


@pytest.mark.parametrize(
    ("hold", "jerk", "pole"),
    [(0.02, 0.0, 20.0), (0.02, 100.0, 8.0), (0.02, 20.0, 4.0), (0.15, 20.0, 8.0 / 3.0), (0.2, 5.0, 1.0)],
)
def test_pairs_are_searched_by_the_pole_that_bounded_jerk_leaves_to_the_barrier(
    hold: float, jerk: float, pole: float
) -> None:
    """At most 0.4 / T and 1 / (T + 2 acc_max / jerk_max) with T = max(hold, 0.05 s)."""
    params = replace(PARAMS, acc_max=2.0, hold=hold, jerk_max=jerk, approach=20.0)
    assert limits_of(params).pole == pytest.approx(pole, rel=1e-12)
