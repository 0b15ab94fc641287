"""Reach of a vehicle: a free fall, a climb at full thrust, and jumps, against their closed forms."""

import math

import numpy as np
import pytest

from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.experiments.licence.commands.plan_reach import beyond_reach, reach_violation
from q2q_sim.firmware.commander.piecewise import Piecewise
from q2q_sim.firmware.commander.polynomial import Goal, Piece, goal_at_rest, piece_between

FULL = CRAZYFLIE_2_0.thrust_max / CRAZYFLIE_2_0.mass
"""Full thrust over the mass [m/s^2]."""


def rest_to_rest(x: float, y: float, z: float, duration: float) -> Piece:
    return piece_between(goal_at_rest(np.zeros(3), 0.0), goal_at_rest(np.array([x, y, z]), 0.0), duration)


def test_the_reach_is_that_of_full_thrust_up_down_and_aside():
    up, down = 0.5 * (FULL - GRAVITY) * 0.25, 0.5 * (FULL + GRAVITY) * 0.25
    aside = math.sqrt(FULL**2 - GRAVITY**2) * 0.5 * 0.25
    for end in ((0.0, 0.0, up), (0.0, 0.0, -down), (aside, 0.0, 0.0), (0.0, -aside, 0.0)):
        assert beyond_reach(rest_to_rest(*end, 0.5), 1.0, CRAZYFLIE_2_0) == pytest.approx(0.0, abs=1e-9)
    beyond = beyond_reach(rest_to_rest(0.0, 0.0, up + 0.2, 0.5), 1.0, CRAZYFLIE_2_0)
    assert beyond == pytest.approx(0.2)
    assert beyond_reach(rest_to_rest(0.0, 0.0, up + 0.2, 0.25), 2.0, CRAZYFLIE_2_0) == pytest.approx(0.2)


def test_speed_takes_a_vehicle_along():
    start = Goal(np.zeros(3), np.array([5.0, 0.0, 0.0]), np.zeros(3), 0.0, np.zeros(3))
    end = Goal(np.array([1.0, 0.0, 0.0]), np.array([5.0, 0.0, 0.0]), np.zeros(3), 0.0, np.zeros(3))
    piece = piece_between(start, end, 0.2)
    expected = 0.5 * (GRAVITY - FULL) * 0.04  # only the weight is to be carried
    assert beyond_reach(piece, 1.0, CRAZYFLIE_2_0) == pytest.approx(expected)
    slower = 0.5 * (GRAVITY - FULL) * 0.16
    assert beyond_reach(piece, 2.0, CRAZYFLIE_2_0) == pytest.approx(slower)


def test_a_short_step_a_quick_one_and_a_jump_are_told_apart():
    def told(*pieces: Piece, backwards: bool = False) -> str:
        return reach_violation(Piecewise(pieces, 0.0, backwards=backwards), CRAZYFLIE_2_0)

    assert told(rest_to_rest(0.05, 0.0, 0.0, 0.05)) == ""  # a small step of a PositionHlCommander
    assert told(rest_to_rest(0.0, 0.0, 0.5, 0.5)) == ""
    beyond = math.hypot(2.0, 0.5 * GRAVITY * 0.16) - 0.5 * FULL * 0.16
    assert told(rest_to_rest(2.0, 0.0, 0.0, 0.4)).startswith(f"a place that is {beyond:.2f} m farther")
    first, second = rest_to_rest(1.0, 0.0, 0.0, 2.0), rest_to_rest(0.0, 0.0, 0.0, 2.0)
    for backwards in (False, True):
        jumps = told(first, second, backwards=backwards)
        assert jumps == "a trajectory that jumps by 1.00 m between two pieces"
    assert told(second, rest_to_rest(1.0, 0.0, 0.0, 2.0)) == ""
    nothing = Piece(2.0, np.full((4, 8), math.nan))
    assert told(nothing, nothing) == ""
