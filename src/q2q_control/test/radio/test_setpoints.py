"""RPYT and full-state setpoints have the signs, scale and limits of cflib."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from resting_signals import resting_setpoint

from q2q_control.radio.link.rpyt_scale import RpytScale
from q2q_control.radio.link.setpoints import (
    RpytSetpoint,
    full_states,
    level_rpyt,
    rpyt_setpoints,
)
from q2q_model.geometry.rotations import euler_from_quat
from q2q_model.signals.values import (
    Interference,
    SwarmCommand,
    SwarmSetpoint,
)

NAMES = ("cf1", "cf2")


@given(*[st.floats(-0.5, 0.5)] * 3, st.floats(0.0, 0.439))
def test_rpyt_setpoints_have_the_signs_of_cflib_and_the_scale_of_the_firmware(
    roll: float, pitch: float, yaw_rate: float, thrust: float
) -> None:
    one = np.ones(1)
    command = SwarmCommand(
        0.0, ("cf1",), thrust * one, roll * one, pitch * one, yaw_rate * one, np.zeros(1, np.uint8)
    )
    (sent,) = rpyt_setpoints(command, RpytScale(0.48))
    assert sent is not None
    assert sent.roll_deg == pytest.approx(math.degrees(roll))
    assert sent.pitch_deg == pytest.approx(math.degrees(pitch))
    assert sent.yaw_rate_deg == pytest.approx(-math.degrees(yaw_rate))
    assert sent.pwm == pytest.approx(thrust * 65535.0 / 0.48, abs=0.5)


def test_full_states_carry_the_acceleration_less_the_downwash_of_the_same_vehicle() -> None:
    rows = np.arange(6.0).reshape(2, 3)
    setpoint = SwarmSetpoint(
        0.0,
        NAMES,
        rows,
        rows + 10,
        rows + 20,
        np.array([0.3, -0.4]),
        np.array([0.1, 0.2]),
        np.zeros(2, np.uint8),
    )
    downwash = Interference(
        0.0,
        ("cf2", "cf9"),
        np.array([[0.0, 0.0, -1.5], [9.0, 9.0, 9.0]]),
        np.zeros((2, 3)),
        np.zeros(2, np.uint8),
    )
    first, second = full_states(setpoint, downwash)
    assert first is not None
    assert second is not None
    assert first.acc == (20.0, 21.0, 22.0)
    assert second.acc == (23.0, 24.0, 26.5)
    assert (second.pos, second.vel, second.ang_vel) == ((3.0, 4.0, 5.0), (13.0, 14.0, 15.0), (0.0, 0.0, 0.2))
    np.testing.assert_allclose(euler_from_quat(np.array(second.quat)), [0.0, 0.0, -0.4], atol=1e-12)
    alone = full_states(setpoint, None)[1]
    assert alone is not None
    assert alone.acc == (23.0, 24.0, 25.0)


def test_a_downwash_that_is_no_number_is_none_and_large_numbers_are_cut() -> None:
    rows = np.full((1, 3), 40.0)
    setpoint = resting_setpoint(0.0, ("cf1",), rows, vel=-rows, acc=rows)
    nan = np.full((1, 3), np.nan)
    (one,) = full_states(setpoint, Interference(0.0, ("cf1",), nan, nan, np.zeros(1, np.uint8)))
    assert one is not None
    assert (one.pos, one.vel, one.acc) == ((32.767,) * 3, (-32.767,) * 3, (32.767,) * 3)


@pytest.mark.parametrize("field", ["thrust", "roll", "pitch", "yaw_rate"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_command_that_is_not_finite_is_none_and_the_others_are_as_without_it(
    field: str, value: float
) -> None:
    rows = {name: np.array([0.3, 0.2]) for name in ("thrust", "roll", "pitch", "yaw_rate")}
    status = np.zeros(2, np.uint8)
    sound = rpyt_setpoints(SwarmCommand(0.0, NAMES, **rows, status=status), RpytScale(0.48))
    rows[field] = np.array([value, 0.2])
    spoilt = rpyt_setpoints(SwarmCommand(0.0, NAMES, **rows, status=status), RpytScale(0.48))
    assert spoilt == [None, sound[1]]
    assert sound[0] is not None


@pytest.mark.parametrize("field", ["pos", "vel", "acc", "yaw", "yaw_rate"])
@pytest.mark.parametrize("value", [np.nan, -np.inf])
def test_a_setpoint_that_is_not_finite_is_none_and_the_others_are_as_without_it(
    field: str, value: float
) -> None:
    rows = {name: np.full((2, 3), 0.5) for name in ("pos", "vel", "acc")}
    rows |= {name: np.full(2, 0.5) for name in ("yaw", "yaw_rate")}
    status = np.zeros(2, np.uint8)
    sound = full_states(SwarmSetpoint(0.0, NAMES, **rows, status=status), None)
    rows[field] = rows[field].copy()
    rows[field][1, ...] = value
    spoilt = full_states(SwarmSetpoint(0.0, NAMES, **rows, status=status), None)
    assert spoilt == [sound[0], None]
    assert sound[1] is not None


def test_a_level_rpyt_setpoint_is_the_thrust_on_the_scale_of_the_firmware() -> None:
    assert level_rpyt(0.034 * 9.81, RpytScale(0.48)) == RpytSetpoint(0.0, 0.0, 0.0, 45539)
