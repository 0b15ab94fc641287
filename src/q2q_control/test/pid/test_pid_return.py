"""A vehicle that is far from its setpoint returns to it at a bounded speed."""

import math
from dataclasses import replace

import numpy as np
import pytest
from pid_swarms import swarm

from q2q_control.pid.pid import Pid, pid_gains
from q2q_control.pid.pid_params import PidParams
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY

DT = 0.01
"""The house's tick [s]."""
STIFF = PidParams(k_p_z=12.0, k_d_z=6.0)
"""A fast altitude loop: by these gains alone 4 m of error are 8 m/s."""


def flown(params: PidParams, pos: Array, vel: Array, seconds: float) -> tuple[Array, Array]:
    """Return positions and velocities (k, 3) of a point mass without lag that is led to the origin."""
    pid, track = Pid(params, CRAZYFLIE_2_0), []
    for k in range(round(seconds / DT)):
        state, setpoint, _ = swarm(("cf1",), k * DT)
        command = pid.update(replace(state, pos=pos[None], vel=vel[None]), setpoint, None)
        specific = float(command.thrust[0]) / CRAZYFLIE_2_0.mass
        acc = np.array([specific * command.pitch[0], -specific * command.roll[0], specific - GRAVITY])
        vel = vel + DT * acc
        pos = pos + DT * vel
        track.append((pos, vel))
    return np.array([one for one, _ in track]), np.array([one for _, one in track])


def test_one_that_is_carried_up_sinks_no_faster_than_told_and_stops_at_its_setpoint():
    pos, vel = flown(STIFF, np.array([0.0, 0.0, 4.0]), np.array([0.0, 0.0, 4.0]), 8.0)
    assert pos[:, 2].max() > 4.5
    assert vel[:, 2].min() == pytest.approx(-2.0, abs=0.05)
    assert pos[:, 2].min() > -0.05
    assert abs(pos[-1, 2]) < 0.01
    _, fast = flown(
        replace(STIFF, return_speed_max=20.0), np.array([0.0, 0.0, 4.0]), np.array([0.0, 0.0, 4.0]), 8.0
    )
    assert fast[:, 2].min() < -5.0


def test_one_that_is_blown_aside_returns_straight_at_the_speed_told():
    pos, vel = flown(replace(STIFF, return_speed_max=1.0), np.array([3.0, -4.0, 0.0]), np.zeros(3), 12.0)
    speed = np.linalg.norm(vel[:, :2], axis=1)
    assert speed.max() == pytest.approx(1.0, abs=0.02)
    assert np.abs(4.0 * pos[:, 0] + 3.0 * pos[:, 1]).max() < 1e-9
    assert np.linalg.norm(pos[-1]) < 0.01


def test_nothing_is_integrated_while_an_error_is_cut():
    params = PidParams(k_i_xy=1.0, k_i_z=1.0, return_speed_max=0.5)
    side, height = pid_gains(params).error_max
    state, setpoint, _ = swarm(("cf1",))
    for off, grows in ((0.9, True), (1.1, False)):
        pid, thrusts = Pid(params, CRAZYFLIE_2_0), []
        for k in range(5):
            low = replace(state, pos=np.array([[0.0, 0.0, -off * height]]), t=k * DT)
            thrusts.append(float(pid.update(low, replace(setpoint, t=k * DT), None).thrust[0]))
        assert (thrusts[-1] > thrusts[1]) == grows
    assert side == pytest.approx(3.6 * 0.5 / 4.0)


@pytest.mark.parametrize("gains", [{"k_d_xy": 0.0}, {"k_p_xy": 0.0}])
def test_a_loop_without_damping_or_stiffness_has_no_error_that_is_cut(gains: dict[str, float]):
    assert pid_gains(PidParams(**gains)).error_max[0] == math.inf


def test_a_height_without_damping_is_led_by_its_whole_error():
    state, setpoint, _ = swarm(("cf1",))
    low = replace(state, pos=np.array([[0.0, 0.0, -3.0]]))
    command = Pid(PidParams(k_p_z=0.5, k_d_z=0.0), CRAZYFLIE_2_0).update(low, setpoint, None)
    assert command.thrust[0] == pytest.approx(CRAZYFLIE_2_0.mass * (GRAVITY + 0.5 * 3.0), rel=1e-12)
