"""The onboard attitude loop turns every vehicle as its natural-frequency form says."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.signal import TransferFunction, step

from q2q_control.attitude.attitude_law import (
    AttitudeParams,
    attitude_gains,
    attitude_torque,
    attitude_torques,
)
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, TEXTBOOK_065, Vehicle

FINITE = st.floats(-3.0, 3.0)
THREE = arrays(np.float64, 3, elements=FINITE)


@settings(deadline=None)  # the first call compiles
@given(attitude=THREE, rates=THREE, torque=THREE, desired=THREE, lead=st.floats(0.0, 1.0))
def test_compiled_scalar_law_equals_the_batch_law(
    attitude: Array, rates: Array, torque: Array, desired: Array, lead: float
):
    gains = attitude_gains(AttitudeParams(lead_ratio=lead), CRAZYFLIE_2_0)
    batch = attitude_torques(attitude[None], rates[None], torque[None] * 1e-4, desired[None], gains)[0]
    # the terms are of order 0.1 N m: 1e-13 is their rounding
    assert np.allclose(attitude_torque(attitude, rates, torque * 1e-4, desired, gains), batch, atol=1e-13)


@pytest.mark.parametrize("vehicle", [CRAZYFLIE_2_0, TEXTBOOK_065, replace(TEXTBOOK_065, thrust_lag=0.1)])
def test_a_roll_step_follows_the_designed_response_whatever_inertia_and_rotor_lag(vehicle: Vehicle):
    params = AttitudeParams()
    t, roll = _simulated_roll_step(vehicle, params, seconds=0.4)
    w, zeta = params.frequency, params.damping
    poles = np.polymul([1.0, 2.0 * zeta * w, w**2], [vehicle.thrust_lag, 1.0])
    _, closed = step(TransferFunction([w**2], np.trim_zeros(poles)), T=t)
    # 0.1 rad step; semi-implicit Euler at 0.1 ms errs by about w dt = 0.0015 of the step
    assert np.abs(roll - 0.1 * closed).max() < 0.1 * 0.002


def _simulated_roll_step(vehicle: Vehicle, params: AttitudeParams, seconds: float) -> tuple[Array, Array]:
    dt, lag = 1e-4, vehicle.thrust_lag
    gains = attitude_gains(params, vehicle)
    desired = np.array([0.1, 0.0, 0.0])
    attitude, rates, torque = np.zeros(3), np.zeros(3), np.zeros(3)
    rolls = [0.0]
    for _ in range(round(seconds / dt)):
        commanded = np.array(attitude_torque(attitude, rates, torque, desired, gains))
        torque = commanded if lag == 0.0 else torque + dt / lag * (commanded - torque)
        rates = rates + dt * torque / np.array(vehicle.inertia)
        attitude = attitude + dt * rates
        rolls.append(attitude[0])
    return np.arange(len(rolls)) * dt, np.array(rolls)


def test_torque_cancels_the_gyroscopic_term_of_a_turning_body():
    gains = attitude_gains(AttitudeParams(), TEXTBOOK_065)
    rates = np.array([1.0, -2.0, 3.0])
    inertia = np.array(TEXTBOOK_065.inertia)
    torque = np.array(attitude_torque(np.zeros(3), rates, np.zeros(3), np.array([0.0, 0.0, 3.0]), gains))
    ang_acc = (torque - np.cross(rates, inertia * rates)) / inertia  # Euler's equation
    w, zeta = AttitudeParams().frequency, AttitudeParams().damping
    assert np.allclose(ang_acc[:2], -2.0 * zeta * w * rates[:2])
    assert abs(ang_acc[2]) < 1e-12  # the yaw rate is the desired one; rounding only


def test_a_parameter_out_of_range_names_itself_and_what_is_allowed():
    with pytest.raises(ValueError, match=r"frequency = 0.0; must be in \[1.0, 100.0\] rad/s"):
        AttitudeParams(frequency=0.0)
