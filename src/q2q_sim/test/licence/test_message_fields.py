"""Fields of ROS messages refuse what ROS would garble, and take what it takes."""

import math
from array import array
from fractions import Fraction

import numpy as np
import pytest

from q2q_sim.licence.crazyflie_py.message_fields import (
    coefficients,
    real,
    seconds,
    three,
    whole,
)
from q2q_sim.licence.crazyflie_py.uav_trajectory import Polynomial


def test_fields_of_messages_refuse_what_ros_would_garble():
    assert real(np.float64(1.5), "z") == 1.5
    assert three(np.array([1.0, 2.0, 3.0]), "goal") == (1.0, 2.0, 3.0)
    for wrong in (1, np.float32(1.0), np.int64(1)):
        with pytest.raises(TypeError, match="a ROS message needs a float"):
            real(wrong, "takeoff: targetHeight")
    with pytest.raises(TypeError, match=r"groupMask = 256; must be an int in \[0, 255\]"):
        whole(256, "groupMask", 255)


@pytest.mark.parametrize("given", [2.5, np.float32(2.5), np.array(2.5), Fraction(5, 2)])
def test_a_duration_may_be_any_real_number(given: float) -> None:
    assert seconds(given, "goTo: duration") == 2.5


def test_a_duration_is_cut_to_nanoseconds_and_may_be_a_whole_number_of_numpy() -> None:
    assert [seconds(one, "duration") for one in (2, np.int64(2), True, -1.0)] == [2.0, 2.0, 1.0, -1.0]
    assert seconds(1.9e-9, "duration") == 1e-9


@pytest.mark.parametrize(("given", "kind"), [
    ("2", TypeError), (None, TypeError), ([2.0], TypeError), (math.nan, ValueError),
    (math.inf, OverflowError), (2.0**31, OverflowError), (np.str_("2"), TypeError),
    (np.datetime64("2020"), TypeError),
])  # fmt: skip
def test_what_rclpy_makes_no_duration_of_is_refused(given: float, kind: type[Exception]) -> None:
    with pytest.raises(kind, match=r"goTo: duration = .*; must be seconds between"):
        seconds(given, "goTo: duration")


def test_coefficients_are_uploaded_from_arrays_only_and_a_derivative_has_a_list_of_them() -> None:
    one = Polynomial(np.array([1.0, 2.0, 3.0]))
    for given in (one.p, array("d", one.p)):
        assert coefficients(given, "px.p").tolist() == [1.0, 2.0, 3.0]
    with pytest.raises(TypeError, match=r"px\.p = \[2\.0, 6\.0\] is of type list: .* a numpy array"):
        coefficients(one.derivative().p, "px.p")
