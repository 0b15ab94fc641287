"""Corrected predictions: the delay margin of the MPC's bandwidth, and the residual along its horizon."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_control.mpc.correction import CROSSING, DELAY_MARGIN, faded_residual, tightened
from q2q_control.mpc.mpc_params import MpcParams
from q2q_model.downwash.residual_process import ResidualProcess
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, CRAZYFLIE_2_1, TEXTBOOK_065


def test_a_delay_of_the_margin_brings_the_open_loop_to_minus_one() -> None:
    width = 7.0
    s = 1j * CROSSING * width
    loop = (np.sqrt(2.0) * width * s + width**2) / s**2 * np.exp(-s * DELAY_MARGIN / width)
    assert loop == pytest.approx(-1.0, abs=1e-12)


def test_the_bandwidth_is_bounded_by_lag_and_stage_and_never_lowered() -> None:
    params = MpcParams()
    assert tightened(params, CRAZYFLIE_2_1).bandwidth_z == pytest.approx(0.736 / 0.086, rel=1e-3)
    assert tightened(params, CRAZYFLIE_2_0).bandwidth_z == pytest.approx(10.0)  # half a radian in 0.05 s
    assert tightened(params, TEXTBOOK_065).bandwidth_z == pytest.approx(10.0)
    assert tightened(replace(params, bandwidth_z=20.0), CRAZYFLIE_2_0).bandwidth_z == 20.0


def test_the_residual_fades_along_the_horizon_as_its_process() -> None:
    params, process = MpcParams(latency=0.03), ResidualProcess(time_s=0.1)
    lost = faded_residual(np.array([2.0, -1.0]), process, params)
    assert lost.shape == (2, params.steps)
    assert lost[0, 0] == pytest.approx(2.0 * (1.0 - np.exp(-0.055 / 0.1)))
    assert lost[1, -1] == pytest.approx(-1.0, abs=1e-6)
