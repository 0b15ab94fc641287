"""Tests of the fastest return, against time-optimal motions in closed form."""

import numpy as np
import pytest

from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_sim.experiments.promise.fastest_return import can_return

NEAR = 0.05
UNBOUNDED = SafeReplannerParams(acc_max=2.0, speed_max=50.0)


def at_rest(distance: float) -> np.ndarray:
    offset = np.zeros((2, 3, 3))
    offset[1, 2, 0] = distance
    return offset


def farthest(seconds: float, acc: float) -> float:
    """Distance from which a fastest stop NEAR behind the end is NEAR before it in time."""
    return acc * (0.5 * (seconds + np.sqrt(4.0 * NEAR / acc))) ** 2 - NEAR


@pytest.mark.parametrize("seconds", [0.5, 1.0])
def test_without_a_bound_of_jerk_full_acceleration_and_full_stop_are_fastest(
    seconds: float,
) -> None:
    limit = farthest(seconds, UNBOUNDED.acc_max)
    assert can_return(at_rest(limit - 0.01), seconds, NEAR, UNBOUNDED)
    assert not can_return(at_rest(limit + 0.01), seconds, NEAR, UNBOUNDED)


def test_a_bound_of_speed_bounds_the_distance() -> None:
    slow = SafeReplannerParams(acc_max=50.0, speed_max=0.5)
    assert can_return(at_rest(0.5), 1.0, NEAR, slow)
    assert not can_return(at_rest(0.56), 1.0, NEAR, slow)


def test_a_bound_of_jerk_takes_time_for_every_change_of_acceleration() -> None:
    """Four equal parts of jerk go 2 j (T/4)^3 from rest to rest, here 0.31 m in 1 s."""
    smooth = SafeReplannerParams(acc_max=50.0, speed_max=50.0, jerk_max=10.0)
    assert can_return(at_rest(0.31), 1.0, 1e-6, smooth)
    assert not can_return(at_rest(0.33), 1.0, 1e-6, smooth)


def test_who_is_there_but_too_fast_to_stop_is_not_back() -> None:
    passing = np.zeros((1, 3, 3))
    passing[0, 0, :2] = -1.5, 1.5
    assert not can_return(passing, 1.0, NEAR, SafeReplannerParams(acc_max=0.5))
