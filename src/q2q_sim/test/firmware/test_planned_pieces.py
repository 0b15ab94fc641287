"""Polynomials of the high-level commander: the firmware's own formula, exact ends, circles."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from yaw_rounding import YAW_32

from q2q_model.signals.values import Array
from q2q_sim.firmware.commander.polynomial import Goal, goal_at, goal_at_rest, piece_between
from q2q_sim.firmware.commander.spiral import Spiral, spiral_piece

Numbers = tuple[float, ...]
NUMBER = st.floats(-5.0, 5.0)
VECTOR = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)
GOAL = st.builds(
    lambda pos, vel, acc, yaw, rate: Goal(pos, vel, acc, yaw, np.array([0.0, 0.0, rate])),
    VECTOR, VECTOR, VECTOR, st.floats(-3.0, 3.0), NUMBER,
)  # fmt: skip


def firmware_formula(start: Numbers, end: Numbers, T: float) -> Array:
    """Return the coefficients as modules/src/pptraj.c (poly7_nojerk) states them, of value, slope, curve."""
    (x0, dx0, ddx0), (xf, dxf, ddxf) = start, end
    gap = x0 - xf
    return np.array(
        [
            x0,
            dx0,
            ddx0 / 2,
            0.0,
            -(5 * (14 * gap + 8 * T * dx0 + 6 * T * dxf + 2 * T**2 * ddx0 - T**2 * ddxf)) / (2 * T**4),
            (84 * gap + 45 * T * dx0 + 39 * T * dxf + 10 * T**2 * ddx0 - 7 * T**2 * ddxf) / T**5,
            -(140 * gap + 72 * T * dx0 + 68 * T * dxf + 15 * T**2 * ddx0 - 13 * T**2 * ddxf) / (2 * T**6),
            (2 * (10 * gap + 5 * T * dx0 + 5 * T * dxf + T**2 * ddx0 - T**2 * ddxf)) / T**7,
        ]
    )


@settings(deadline=None)
@given(GOAL, GOAL, st.floats(0.3, 10.0))
def test_pieces_are_those_of_the_firmwares_formula(start: Goal, end: Goal, duration: float) -> None:
    piece = piece_between(start, end, duration)
    for axis in range(3):
        ends = [(one.pos[axis], one.vel[axis], one.acc[axis]) for one in (start, end)]
        expected = firmware_formula(ends[0], ends[1], duration)
        scale = duration ** np.arange(8)  # compare the terms of x at the end, in metres
        np.testing.assert_allclose(piece.coefficients[axis] * scale, expected * scale, atol=1e-9 * 1e4)


@settings(deadline=None)
@given(GOAL, GOAL, st.floats(0.3, 10.0))
def test_pieces_meet_position_velocity_acceleration_and_yaw_at_both_ends(
    start: Goal, end: Goal, duration: float
) -> None:
    piece = piece_between(start, end, duration)
    for tau, demanded in ((0.0, start), (duration, end)):
        goal = goal_at(piece, tau)
        size = 1e-9 * (1.0 + 1e4 / duration**2)  # rounding of terms of up to 1e4 m
        np.testing.assert_allclose(goal.pos, demanded.pos, atol=size)
        np.testing.assert_allclose(goal.vel, demanded.vel, atol=size)
        np.testing.assert_allclose(goal.acc, demanded.acc, atol=size)
        assert goal.yaw == pytest.approx(demanded.yaw, abs=size)


def test_a_piece_of_no_duration_is_at_its_end_at_once() -> None:
    goal = goal_at(piece_between(goal_at_rest(np.zeros(3), 0.0), goal_at_rest(np.ones(3), 0.5), 0.0), 0.0)
    np.testing.assert_array_equal(goal.pos, np.ones(3))
    assert goal.yaw == 0.5


def test_body_rates_are_those_of_the_turning_thrust() -> None:
    piece = piece_between(goal_at_rest(np.zeros(3), 0.3), goal_at_rest(np.array([2.0, 1.0, 0.5]), 0.3), 2.0)
    dt, t = 1e-5, 0.6

    def up(tau: float) -> Array:
        thrust = goal_at(piece, tau).acc + np.array([0.0, 0.0, 9.81])
        return thrust / np.linalg.norm(thrust)

    turn = (up(t + dt) - up(t - dt)) / (
        2 * dt
    )  # = omega x z_body: x part -> rate about y, y part -> minus about x
    z = up(t)
    y = np.cross(z, [math.cos(0.3), math.sin(0.3), 0.0])
    y /= np.linalg.norm(y)
    x = np.cross(y, z)
    rates = goal_at(piece, t).ang_vel_body
    assert rates[1] == pytest.approx(float(turn @ x), rel=1e-5)  # finite differences of 1e-5 s
    assert rates[0] == pytest.approx(-float(turn @ y), rel=1e-5)


@pytest.mark.parametrize(
    ("clockwise", "sideways"), [(False, False), (True, False), (False, True), (True, True)]
)
def test_a_quarter_circle_keeps_its_radius_and_its_speed(clockwise: bool, sideways: bool) -> None:
    here = goal_at_rest(np.array([1.0, 2.0, 1.0]), 0.4)
    radius, duration = 0.5, 2.0
    piece = spiral_piece(here, Spiral(math.pi / 2, radius, radius, 0.2, duration, sideways, clockwise))
    first, last = goal_at(piece, 0.0), goal_at(piece, duration)
    to_left = np.array([-first.vel[1], first.vel[0]]) / np.linalg.norm(first.vel[:2])
    centre = here.pos[:2] + radius * to_left * (-1.0 if clockwise else 1.0)
    for tau in np.linspace(0.0, duration, 9):
        goal = goal_at(piece, tau)
        away = np.linalg.norm(goal.pos[:2] - centre)
        assert away == pytest.approx(radius, rel=0.01)  # no jerk at its ends, so no exact circle
        assert np.linalg.norm(goal.vel[:2]) == pytest.approx(radius * math.pi / 2 / duration, rel=0.05)
    assert last.pos[2] - first.pos[2] == pytest.approx(0.2)
    assert last.yaw - first.yaw == pytest.approx((-1.0 if clockwise else 1.0) * math.pi / 2)
    ahead = np.array([math.cos(0.4), math.sin(0.4)]) @ first.vel[:2] / np.linalg.norm(first.vel[:2])
    assert abs(ahead) == pytest.approx(0.0 if sideways else 1.0, abs=YAW_32)
    if not sideways:
        assert ahead > 0.0
