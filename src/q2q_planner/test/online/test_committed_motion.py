"""Committed motions go on from tick to tick; a reference is joined only where it keeps the bounds."""

from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_setpoint

from q2q_model.signals.values import Names, SwarmSetpoint
from q2q_planner.online.safe.motion.committed_motion import CommittedMotion
from q2q_planner.online.safe.motion.followed_reference import (
    follow_bounds,
    followed_rows,
    near_rows,
    reference_rows,
)
from q2q_planner.online.safe.motion.motion_propagation import at_reference, propagate
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams

PARAMS = SafeReplannerParams(acc_max=2.0, jerk_max=20.0, speed_max=2.5, hold=0.04)


def resting(t: float, names: Names) -> SwarmSetpoint:
    """Return a reference on which vehicles rest side by side, 1 m apart."""
    n = len(names)
    pos = np.column_stack([np.arange(float(n)), np.zeros(n), np.ones(n)])
    return resting_setpoint(t, names, pos)


def moving() -> CommittedMotion:
    """Return one vehicle at 1 m/s, off its reference, that holds a jerk for 0.1 s more."""
    one = at_reference(resting(2.0, ("cf1",)))
    rows = one.rows._replace(
        vel=np.array([[1.0, 0.0, 0.0]]),
        hold=np.array([0.1]),
        on_reference=np.array([False]),
        pushed=np.array([True]),
        jerk=np.array([[0.0, 6.0, 0.0]]),
    )
    return one.with_rows(rows)


def test_a_new_vehicle_starts_on_its_reference_and_the_others_go_on() -> None:
    motion = propagate(moving(), resting(2.01, ("cf0", "cf1")), PARAMS)
    both, alone = motion.rows, propagate(moving(), resting(2.01, ("cf1",)), PARAMS).rows
    assert motion.names == ("cf0", "cf1")
    assert both.hold.tolist() == [0.0, pytest.approx(0.09)]
    assert both.jerk.tolist() == [[0.0, 0.0, 0.0], [0.0, 6.0, 0.0]]
    assert both.on_reference.tolist() == [True, False]
    assert both.pushed.tolist() == [False, True]
    np.testing.assert_array_equal(both.pos, [[0.0, 0.0, 1.0], alone.pos[0]])
    np.testing.assert_array_equal(both.vel, [[0.0, 0.0, 0.0], alone.vel[0]])
    np.testing.assert_array_equal(both.acc, [[0.0, 0.0, 0.0], alone.acc[0]])


def test_a_held_jerk_is_integrated_over_the_tick() -> None:
    moved = propagate(moving(), resting(2.01, ("cf1",)), PARAMS).rows
    np.testing.assert_allclose(moved.acc, [[0.0, 6.0 * 0.01, 0.0]], atol=1e-12)
    np.testing.assert_allclose(moved.vel, [[1.0, 0.5 * 6.0 * 0.01**2, 0.0]], atol=1e-12)
    np.testing.assert_allclose(moved.pos, [[0.01, 6.0 * 0.01**3 / 6.0, 1.0]], atol=1e-12)


def test_a_vehicle_is_near_its_reference_by_place_and_by_speed_unless_it_is_pushed() -> None:
    asked = resting(2.0, ("cf1", "cf2", "cf3", "cf4"))
    on = at_reference(asked).rows
    off = on._replace(
        pos=on.pos + np.array([[0.9e-4, 0, 0], [1.1e-4, 0, 0], [0, 0, 0], [0, 0, 0]]),
        vel=on.vel + np.array([[0, 4.9e-3, 0], [0, 0, 0], [0, 5.1e-3, 0], [0, 0, 0]]),
        pushed=np.array([False, False, False, True]),
    )
    assert near_rows(off, reference_rows(asked)).tolist() == [True, False, False, False]


@pytest.mark.parametrize(
    ("name", "asked", "followed"),
    [
        ("acc", [2.0, 0.0, 0.0], True),
        ("acc", [0.0, -2.1, 0.0], False),  # more than acc_max
        ("acc", [1.3, 1.6, 0.0], False),  # by its size, not by its parts
        ("vel", [0.0, 0.0, 2.5], True),
        ("vel", [0.0, 0.0, -2.6], False),  # more than speed_max
        ("vel", [2.0, 2.0, 0.0], False),
    ],
)
def test_a_reference_is_followed_within_acceleration_and_speed(
    name: str, asked: list[float], followed: bool
) -> None:
    reference = replace(resting(2.0, ("cf1",)), **{name: np.array([asked])})
    assert follows(reference) == followed


@pytest.mark.parametrize(
    ("acc", "most"),
    [
        ([1.0, 0.0, 0.0], 2.425),  # its lag of 0.05 s adds 0.05 m/s, its ramp at 20 m/s^3 0.025 m/s
        ([2.0, 0.0, 0.0], 2.3),  # 0.1 and 0.1 m/s
        ([-2.0, 0.0, 0.0], 2.5),
        ([0.0, 2.0, 0.0], np.sqrt(2.5**2 - 0.18**2)),  # aside: 0.08 m/s in its hold of 0.04 s, 0.1 m/s after
    ],
)
def test_a_reference_is_left_while_its_acceleration_can_be_taken_back_below_the_largest_speed(
    acc: list[float], most: float
) -> None:
    for speed, followed in ((most - 1e-6, True), (most + 1e-6, False)):
        vel = np.array([[speed, 0.0, 0.0]])
        assert follows(replace(resting(2.0, ("cf1",)), vel=vel, acc=np.array([acc]))) == followed


def follows(reference: SwarmSetpoint) -> bool:
    """Return whether a vehicle on a reference, and with its acceleration, stays on it."""
    same = at_reference(reference).rows._replace(vel=np.zeros((1, 3)))
    return bool(followed_rows(same, reference_rows(reference), follow_bounds(PARAMS, PARAMS.hold))[0])


@pytest.mark.parametrize(("asked", "followed"), [(-0.61, False), (-0.59, True), (0.99, True), (1.01, False)])
def test_a_reference_is_followed_from_the_acceleration_at_the_tick_before(
    asked: float, followed: bool
) -> None:
    """It was 0.2 m/s^2, and has become 1 m/s^2 by the largest jerk since: not both may change."""
    reference = replace(resting(2.0, ("cf1",)), acc=np.array([[0.0, asked, 0.0]]))
    jerk, now = np.array([[0.0, 20.0, 0.0]]), np.array([[0.0, 1.0, 0.0]])
    rows = at_reference(reference).rows._replace(acc=now, jerk=jerk)
    may = followed_rows(rows, reference_rows(reference), follow_bounds(PARAMS, PARAMS.hold))
    assert may.tolist() == [followed]


@pytest.mark.parametrize(
    ("before", "asked", "followed"),
    [
        (0.0, 0.8, True),
        (0.0, -0.81, False),  # a jump of more than jerk_max hold = 0.8 m/s^2
        (0.5, -0.31, False),
        (0.5, -0.29, True),
        (1.5, 1.5, True),
    ],
)
def test_a_reference_is_followed_if_its_acceleration_jumps_by_no_more_than_the_jerk_allows(
    before: float, asked: float, followed: bool
) -> None:
    reference = replace(resting(2.0, ("cf1",)), acc=np.array([[0.0, asked, 0.0]]))
    rows = at_reference(reference).rows._replace(acc=np.array([[0.0, before, 0.0]]))
    may = followed_rows(rows, reference_rows(reference), follow_bounds(PARAMS, PARAMS.hold))
    assert may.tolist() == [followed]
