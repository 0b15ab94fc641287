"""Rotor thrusts give back the wrench they were made from, and the documented part of it at the limits."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from q2q_control.attitude.allocation import rotor_frame, rotors_of, wrench_of
from q2q_control.attitude.allocation_kernel import allocate, packed_frame
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

FRAME = rotor_frame(CRAZYFLIE_2_0)
SIDE = st.floats(-0.01, 0.01)
WRENCH = st.builds(lambda u, x, y, z: np.array([u, x, y, z]), st.floats(-0.3, 1.0), SIDE, SIDE, SIDE)
ROUNDING = 1e-12
"""Thrusts are of order 0.1 N, levers 0.03 m."""


IN_THE_BOX = st.lists(st.floats(0.0, FRAME.rotor_max), min_size=4, max_size=4)


@given(rotors=IN_THE_BOX)
def test_round_trip_is_exact_wherever_the_rotors_can_be(rotors: list[float]):
    again = rotors_of(wrench_of(np.array(rotors), FRAME), FRAME)
    assert np.allclose(again, rotors, atol=ROUNDING)


@given(rotors=IN_THE_BOX)
def test_thrust_first_round_trip_is_exact_where_the_tilt_fits_without_yaw(rotors: list[float]):
    wrench = wrench_of(np.array(rotors), FRAME)
    turning = np.array([-1.0, 1.0, -1.0, 1.0])
    without_yaw = np.array(rotors) - turning * (turning @ np.array(rotors)) / 4.0
    if without_yaw.min() >= 0.0 and without_yaw.max() <= FRAME.rotor_max:
        assert np.allclose(rotors_of(wrench, FRAME, attitude_first=False), rotors, atol=ROUNDING)


@settings(deadline=None)  # the first call compiles
@example(wrench=np.array([0.005859375, 0.005859375, 0.0, 0.0]), first=False)  # a rotor a rounding below zero
@given(wrench=WRENCH, first=st.booleans())
def test_compiled_kernel_equals_the_batch_law(wrench: Array, first: bool):
    rotors = np.zeros(4)
    allocate(wrench, packed_frame(FRAME), first, rotors)
    assert np.allclose(rotors, rotors_of(wrench, FRAME, attitude_first=first), atol=ROUNDING)


@given(wrench=WRENCH, first=st.booleans())
def test_no_rotor_leaves_its_limits(wrench: Array, first: bool):
    rotors = rotors_of(wrench, FRAME, attitude_first=first)
    assert rotors.min() >= -ROUNDING
    assert rotors.max() <= FRAME.rotor_max + ROUNDING


@given(wrench=WRENCH)
def test_attitude_first_keeps_tilt_torques_when_rotors_can_give_them(wrench: Array):
    wrench = wrench * np.array([1.0, 0.2, 0.2, 1.0])  # 2 mN m an axis: 0.06 N between rotors, of 0.15
    given_back = wrench_of(rotors_of(wrench, FRAME, attitude_first=True), FRAME)
    assert np.allclose(given_back[1:3], wrench[1:3], atol=ROUNDING)
    assert abs(given_back[3]) <= abs(wrench[3]) + ROUNDING


@given(wrench=WRENCH)
def test_thrust_first_keeps_the_collective_and_the_direction_of_tilt(wrench: Array):
    given_back = wrench_of(rotors_of(wrench, FRAME, attitude_first=False), FRAME)
    assert given_back[0] == pytest.approx(np.clip(wrench[0], 0.0, 4.0 * FRAME.rotor_max), abs=ROUNDING)
    turned = given_back[1] * wrench[2] - given_back[2] * wrench[1]
    assert abs(turned) < ROUNDING
    assert given_back[1] * wrench[1] >= -ROUNDING


def test_each_torque_has_the_sign_of_the_drawing():
    right_pair, front_pair, left_turning = [1, 1, 0, 0], [1, 0, 0, 1], [1, 0, 1, 0]
    assert wrench_of(np.array(right_pair, dtype=float), FRAME)[1] < 0.0  # right side up: roll falls
    assert wrench_of(np.array(front_pair, dtype=float), FRAME)[2] < 0.0  # nose up: pitch falls
    assert wrench_of(np.array(left_turning, dtype=float), FRAME)[3] < 0.0  # drags the body to the right


def test_a_batch_of_any_shape_equals_one_by_one():
    wrenches = np.random.default_rng(0).normal(size=(3, 5, 4)) * [0.3, 0.01, 0.01, 0.01]
    whole = rotors_of(wrenches, FRAME)
    singly = np.array([[rotors_of(w, FRAME) for w in row] for row in wrenches])
    assert np.array_equal(whole, singly)
