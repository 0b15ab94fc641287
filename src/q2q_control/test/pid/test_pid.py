"""The PID obeys (22)-(25), keeps its limits, and survives whatever a tick may bring."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pid_swarms import random_swarm, swarm

from q2q_control.attitude.thrust_vector import UPRIGHT_MIN, WEIGHT_MIN, ThrustLimits
from q2q_control.inputs.alignment import (
    ETA,
    POS,
    QUAT,
    REF_ACC,
    REF_POS,
    REF_VEL,
    VEL,
    YAW,
    YAW_RATE,
    Aligned,
)
from q2q_control.pid.pid import Pid, pid_gains, pid_limits
from q2q_control.pid.pid_kernel import pid_rows
from q2q_control.pid.pid_params import PidParams
from q2q_model.geometry.rotations import matrix_from_quat, quat_from_euler, yaw_from_quat
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import (
    Array,
    CommandStatus,
    Interference,
    SwarmSetpoint,
    SwarmState,
)
from q2q_model.vehicle.constants import GRAVITY, TEXTBOOK_065

DT = 0.01
"""The house's tick [s]."""


def table_of(state: SwarmState, setpoint: SwarmSetpoint, eta: Interference) -> Aligned:
    table = np.zeros((len(state.names), 24))
    table[:, POS], table[:, VEL], table[:, QUAT] = state.pos, state.vel, state.quat
    table[:, REF_POS], table[:, REF_VEL], table[:, REF_ACC] = setpoint.pos, setpoint.vel, setpoint.acc
    table[:, YAW], table[:, YAW_RATE], table[:, ETA] = setpoint.yaw, setpoint.yaw_rate, eta.acc
    every = np.ones(len(state.names), bool)
    return Aligned(0.0, state.names, every, every, all_usable=True, table=table)


def commands_by_numpy(acc: Array, quat: Array, limits: ThrustLimits) -> tuple[Array, Array]:
    """Return thrust, roll, pitch (3, n), and where a limit cuts, (n,): (22)-(25) over all rows at once."""
    vertical = GRAVITY + acc[:, 2]
    upright = 1.0 - 2.0 * (quat[:, 0] ** 2 + quat[:, 1] ** 2)
    desired = limits.mass * vertical / np.maximum(upright, UPRIGHT_MIN)
    least = 0.05 * limits.mass * GRAVITY
    thrust = np.clip(desired, least, np.where(upright > 0.0, limits.thrust_max, least))
    yaw = yaw_from_quat(quat)
    forward = acc[:, 0] * np.cos(yaw) + acc[:, 1] * np.sin(yaw)
    left = acc[:, 1] * np.cos(yaw) - acc[:, 0] * np.sin(yaw)
    most = np.tan(limits.tilt_max) if limits.exact else limits.tilt_max
    specific = np.maximum(vertical if limits.exact else thrust / limits.mass, WEIGHT_MIN * GRAVITY)
    side = np.hypot(forward, left) / specific
    share = most / np.maximum(side, most) / specific
    forward, left = forward * share, left * share
    if limits.exact:
        angles = np.stack([-np.arctan2(left, np.hypot(forward, 1.0)), np.arctan(forward)])
    else:
        angles = np.stack([-left, forward])
    return np.concatenate([thrust[None], angles]), (side > most) | (desired != thrust)


def error_by_numpy(error: Array, most: tuple[float, float]) -> Array:
    """Return the errors of position that count, (n, 3)."""
    side = np.linalg.norm(error[:, :2], axis=1, keepdims=True)
    return np.hstack(
        [error[:, :2] * np.minimum(1.0, most[0] / side), np.clip(error[:, 2:], -most[1], most[1])]
    )


@settings(deadline=None)  # the first call compiles
@given(seed=st.integers(0, 10_000), exact=st.booleans(), limited=st.booleans())
def test_compiled_rows_equal_the_numpy_equations(seed: int, exact: bool, limited: bool):
    params = PidParams(exact_inverse=exact, thrust_limited=limited, return_speed_max=1.0)
    tick = table_of(*random_swarm(seed))
    integral = np.random.default_rng(seed).normal(size=(3, 3))
    limits, gains = pid_limits(params, TEXTBOOK_065), pid_gains(params)
    table = tick.table
    counted = error_by_numpy(table[:, REF_POS] - table[:, POS], gains.error_max)
    acc = table[:, REF_ACC] + gains.k_p * counted + integral - table[:, ETA]
    acc += gains.k_d * (table[:, REF_VEL] - table[:, VEL])
    expected, cut = commands_by_numpy(acc, table[:, QUAT], limits)
    values, saturated = pid_rows(table, integral.copy(), gains, limits, DT)
    assert np.allclose(values[:, :3].T, expected, atol=1e-12)
    assert np.array_equal(saturated, cut)


@given(seed=st.integers(0, 10_000))
def test_an_aware_vehicle_climbs_as_desired_whatever_its_tilt_and_downwash(seed: int):
    state, setpoint, eta = random_swarm(seed)
    calm = replace(setpoint, pos=state.pos, vel=state.vel)  # no feedback: a = r'' - eta
    command = Pid(PidParams(), replace(TEXTBOOK_065, thrust_max=99.0)).update(state, calm, eta)
    upward = command.thrust / TEXTBOOK_065.mass * matrix_from_quat(state.quat)[:, 2, 2]
    assert np.allclose(upward - GRAVITY + eta.acc[:, 2], setpoint.acc[:, 2], atol=1e-12)  # eq. (6) + eta


@given(seed=st.integers(0, 10_000))
def test_the_exact_inverse_points_the_thrust_along_the_desired_force(seed: int):
    state, setpoint, eta = random_swarm(seed)
    calm = replace(setpoint, pos=state.pos, vel=state.vel)
    command = Pid(PidParams(exact_inverse=True, tilt_max=1.2), TEXTBOOK_065).update(state, calm, eta)
    yaw = np.arctan2(*matrix_from_quat(state.quat)[:, [1, 0], 0].T)
    axis = matrix_from_quat(quat_from_euler(command.roll, command.pitch, yaw))[:, :, 2]
    force = setpoint.acc - eta.acc + [0.0, 0.0, GRAVITY]
    assert np.allclose(axis, force / np.linalg.norm(force, axis=1)[:, None], atol=1e-12)


def test_small_angles_agree_with_the_exact_inverse_to_second_order():
    state, setpoint, eta = swarm(("cf1",))
    for size in (0.1, 0.2):
        pushed = replace(setpoint, acc=np.array([[size, -size, 0.0]]))
        printed, exact = (
            Pid(PidParams(exact_inverse=inverse), TEXTBOOK_065).update(state, pushed, eta)
            for inverse in (False, True)
        )
        tilt = size / GRAVITY
        # atan(x) = x - x^3/3 and cos = 1 - x^2/2: they part at third order
        assert abs(printed.pitch[0] - exact.pitch[0]) < tilt**3
        assert abs(printed.roll[0] - exact.roll[0]) < tilt**3
        assert printed.pitch[0] > 0.0  # forward: nose down
        assert printed.roll[0] > 0.0  # to the right: right side down


def test_an_altitude_error_decays_as_the_closed_loop_of_22_says():
    params = PidParams(k_p_z=4.0, k_d_z=2.0, k_i_z=1.0)
    pid, names = Pid(params, TEXTBOOK_065), ("cf1",)
    height, climb, seen = 0.1, 0.0, []
    for k in range(500):
        state, setpoint, _ = swarm(names, k * DT)
        state = replace(state, pos=np.array([[0, 0, height]]), vel=np.array([[0, 0, climb]]))
        thrust = pid.update(state, setpoint, None).thrust[0]
        acc = thrust / TEXTBOOK_065.mass - GRAVITY
        height, climb = height + DT * climb + 0.5 * DT**2 * acc, climb + DT * acc
        seen.append(height)
    # e''' + k_d e'' + k_p e' + k_i e = 0 with e = 0.1, e' = 0, e'' = -k_p e
    roots = np.roots([1.0, params.k_d_z, params.k_p_z, params.k_i_z])
    weights = np.linalg.solve(np.vander(roots, 3, increasing=True).T, [0.1, 0.0, -0.4])
    exact = np.real(np.exp(np.outer(np.arange(1, 501) * DT, roots)) @ weights)
    assert np.abs(np.array(seen) - exact).max() < 0.1 * params.k_d_z * DT  # sample and hold: k_d dt / 2


def test_a_command_does_not_change_when_the_other_vehicles_are_hidden():
    whole = random_swarm(7, ("cf1", "cf2", "cf3"))
    all_of_them = Pid(PidParams(), TEXTBOOK_065).update(*whole)
    alone = Pid(PidParams(), TEXTBOOK_065).update(*(of_vehicles(signal, np.array([1])) for signal in whole))
    for part in ("thrust", "roll", "pitch", "yaw_rate"):
        assert getattr(alone, part)[0] == getattr(all_of_them, part)[1]


def test_rows_are_joined_by_name_not_by_order():
    state, setpoint, eta = random_swarm(3)
    parts = ("names", "pos", "vel", "quat", "ang_vel_body", "age", "status")
    turned = replace(state, **{part: getattr(state, part)[::-1] for part in parts})
    straight = Pid(PidParams(), TEXTBOOK_065).update(state, setpoint, eta)
    crossed = Pid(PidParams(), TEXTBOOK_065).update(turned, setpoint, eta)
    assert np.array_equal(crossed.thrust, straight.thrust)


def test_thrust_keeps_the_papers_limit_and_the_rotors_limits_and_stops_no_motors():
    state, setpoint, eta = swarm(("cf1",))
    pull = replace(eta, acc=np.array([[0.0, 0.0, -50.0]]))
    limited = Pid(PidParams(thrust_limited=True), TEXTBOOK_065).update(state, setpoint, pull)
    assert limited.thrust[0] == 6.6
    assert limited.status[0] == CommandStatus.SATURATED
    assert Pid(PidParams(), TEXTBOOK_065).update(state, setpoint, pull).thrust[0] == TEXTBOOK_065.thrust_max
    push = replace(eta, acc=np.array([[0.0, 0.0, 50.0]]))
    least = Pid(PidParams(), TEXTBOOK_065).update(state, setpoint, push)
    assert least.thrust[0] == pytest.approx(0.05 * 0.65 * GRAVITY, rel=1e-12)
    assert least.status[0] == CommandStatus.SATURATED


@pytest.mark.parametrize(("roll_deg", "share"), [(89.9, None), (90.1, 0.05), (122.7, 0.05), (180.0, 0.05)])
def test_a_vehicle_whose_thrust_would_push_it_down_has_the_least(roll_deg: float, share: float | None):
    state, setpoint, eta = swarm(("cf1",))
    tilted = replace(state, quat=quat_from_euler(np.deg2rad(roll_deg), 0.0, 0.0)[None])
    command = Pid(PidParams(), TEXTBOOK_065).update(tilted, setpoint, eta)
    expected = TEXTBOOK_065.thrust_max if share is None else share * TEXTBOOK_065.hover_thrust
    assert command.thrust[0] == pytest.approx(expected, rel=1e-12)
    assert command.status[0] == CommandStatus.SATURATED


def test_a_bound_that_does_not_carry_the_vehicle_is_refused_and_changes_nothing():
    weight = TEXTBOOK_065.hover_thrust  # 6.3765 N
    refused = r"thrust_max = 6.37 N with thrust_limited; must be above the weight of textbook_065, 6.3765 N"
    low = PidParams(thrust_limited=True, thrust_max=6.37)
    with pytest.raises(ValueError, match=refused):
        Pid(low, TEXTBOOK_065)
    pid = Pid(PidParams(), TEXTBOOK_065)
    with pytest.raises(ValueError, match=refused):
        pid.configure(low)
    state, setpoint, eta = swarm(("cf1",))
    pull = replace(eta, acc=np.array([[0.0, 0.0, -50.0]]))
    assert pid.update(state, setpoint, pull).thrust[0] == TEXTBOOK_065.thrust_max
    Pid(replace(low, thrust_limited=False), TEXTBOOK_065)
    Pid(replace(low, thrust_max=weight + 1e-6), TEXTBOOK_065)


@given(seed=st.integers(0, 10_000), exact=st.booleans())
def test_the_thrust_never_leans_further_than_tilt_max(seed: int, exact: bool):
    state, setpoint, eta = random_swarm(seed)
    far = replace(setpoint, pos=setpoint.pos * 100.0)
    command = Pid(PidParams(exact_inverse=exact), TEXTBOOK_065).update(state, far, eta)
    lean = np.arccos(np.cos(command.roll) * np.cos(command.pitch))
    assert lean.max() <= PidParams().tilt_max + 1e-9  # rounding of arccos near 1


def test_yaw_turns_the_short_way_round_within_its_rate():
    state, setpoint, eta = swarm(("cf1",))
    turned = replace(state, quat=quat_from_euler([0.0], [0.0], [3.0]))
    demanded = replace(setpoint, yaw=np.array([-3.0]))
    command = Pid(PidParams(), TEXTBOOK_065).update(turned, demanded, eta)
    assert command.yaw_rate[0] == pytest.approx(PidParams().k_yaw * (2.0 * np.pi - 6.0))
    away = Pid(PidParams(), TEXTBOOK_065).update(state, replace(setpoint, yaw=np.array([3.0])), eta)
    assert away.yaw_rate[0] == PidParams().yaw_rate_max
