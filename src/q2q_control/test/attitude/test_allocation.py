"""Rotor thrusts give back the wrench they were made from, and the documented part of it at the limits."""

import numpy as np
from hypothesis import given, settings
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


@settings(deadline=None)  # the first call compiles
@given(wrench=WRENCH)
def test_compiled_kernel_equals_the_batch_law(wrench: Array):
    rotors = np.zeros(4)
    allocate(wrench, packed_frame(FRAME), rotors)
    assert np.allclose(rotors, rotors_of(wrench, FRAME), atol=ROUNDING)


@given(wrench=WRENCH)
def test_no_rotor_leaves_its_limits(wrench: Array):
    rotors = rotors_of(wrench, FRAME)
    assert rotors.min() >= -ROUNDING
    assert rotors.max() <= FRAME.rotor_max + ROUNDING


@given(wrench=WRENCH)
def test_tilt_torques_are_kept_when_rotors_can_give_them(wrench: Array):
    wrench = wrench * np.array([1.0, 0.2, 0.2, 1.0])  # 2 mN m an axis: 0.06 N between rotors, of 0.15
    given_back = wrench_of(rotors_of(wrench, FRAME), FRAME)
    assert np.allclose(given_back[1:3], wrench[1:3], atol=ROUNDING)
    assert abs(given_back[3]) <= abs(wrench[3]) + ROUNDING


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
