"""The PID obeys (22)-(25), keeps its limits, and survives whatever a tick may bring."""

from dataclasses import replace
from typing import TypeVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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
from q2q_control.pid.pid import Pid, PidParams, pid_gains, pid_limits
from q2q_control.pid.pid_kernel import pid_rows
from q2q_control.pid.thrust_vector import UPRIGHT_MIN, WEIGHT_MIN, ThrustLimits
from q2q_model.geometry.rotations import matrix_from_quat, quat_from_euler, yaw_from_quat
from q2q_model.signals.values import (
    Array,
    CommandStatus,
    Interference,
    Names,
    SwarmSetpoint,
    SwarmState,
    TrackStatus,
)
from q2q_model.vehicle.constants import GRAVITY, TEXTBOOK_065

Signal = TypeVar("Signal", SwarmState, SwarmSetpoint, Interference)

DT = 0.01
"""The house's tick [s]."""


def swarm(names: Names, t: float = 0.0) -> tuple[SwarmState, SwarmSetpoint, Interference]:
    """Return vehicles at rest, level, on their setpoints, in still air."""
    n = len(names)
    zero, flag = np.zeros((n, 3)), np.zeros(n, np.uint8)
    level = np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
    state = SwarmState(t, names, zero, zero, level, zero, np.zeros(n), flag)
    setpoint = SwarmSetpoint(t, names, zero, zero, zero, np.zeros(n), np.zeros(n), flag)
    return state, setpoint, Interference(t, names, zero, zero, flag)


def random_swarm(seed: int, names: Names = ("cf1", "cf2", "cf3")):
    rng = np.random.default_rng(seed)
    state, setpoint, eta = swarm(names)
    n = len(names)
    attitude = quat_from_euler(*rng.uniform(-0.3, 0.3, (2, n)), rng.uniform(-3.0, 3.0, n))
    state = replace(state, pos=rng.normal(size=(n, 3)), vel=rng.normal(size=(n, 3)), quat=attitude)
    yaw, yaw_rate = rng.uniform(-3.0, 3.0, (2, n))
    ref = rng.normal(size=(3, n, 3))
    setpoint = replace(setpoint, pos=ref[0], vel=ref[1], acc=ref[2], yaw=yaw, yaw_rate=yaw_rate)
    return state, setpoint, replace(eta, acc=rng.normal(size=(n, 3)))


def table_of(state: SwarmState, setpoint: SwarmSetpoint, eta: Interference) -> Aligned:
    table = np.zeros((len(state.names), 24))
    table[:, POS], table[:, VEL], table[:, QUAT] = state.pos, state.vel, state.quat
    table[:, REF_POS], table[:, REF_VEL], table[:, REF_ACC] = setpoint.pos, setpoint.vel, setpoint.acc
    table[:, YAW], table[:, YAW_RATE], table[:, ETA] = setpoint.yaw, setpoint.yaw_rate, eta.acc
    return Aligned(0.0, state.names, np.ones(len(state.names), bool), table)


def commands_by_numpy(acc: Array, quat: Array, limits: ThrustLimits) -> tuple[Array, Array]:
    """Return thrust, roll, pitch (3, n), and where a limit cuts, (n,): (22)-(25) over all rows at once."""
    vertical = GRAVITY + acc[:, 2]
    upright = 1.0 - 2.0 * (quat[:, 0] ** 2 + quat[:, 1] ** 2)
    desired = limits.mass * vertical / np.maximum(upright, UPRIGHT_MIN)
    thrust = np.clip(desired, 0.0, limits.thrust_max)
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


@settings(deadline=None)  # the first call compiles
@given(seed=st.integers(0, 10_000), exact=st.booleans(), limited=st.booleans())
def test_compiled_rows_equal_the_numpy_equations(seed: int, exact: bool, limited: bool):
    params = PidParams(exact_inverse=exact, thrust_limited=limited)
    tick = table_of(*random_swarm(seed))
    integral = np.random.default_rng(seed).normal(size=(3, 3))
    limits, gains = pid_limits(params, TEXTBOOK_065), pid_gains(params)
    table = tick.table
    acc = table[:, REF_ACC] + gains.k_p * (table[:, REF_POS] - table[:, POS]) + integral - table[:, ETA]
    acc += gains.k_d * (table[:, REF_VEL] - table[:, VEL])
    expected, cut = commands_by_numpy(acc, table[:, QUAT], limits)
    values, saturated = pid_rows(table, integral.copy(), gains, limits, DT)
    assert np.allclose(values[:, :3].T, expected, atol=1e-12)
    assert np.array_equal(saturated, cut)


@given(seed=st.integers(0, 10_000))
def test_an_aware_vehicle_climbs_as_wanted_whatever_its_tilt_and_downwash(seed: int):
    state, setpoint, eta = random_swarm(seed)
    calm = replace(setpoint, pos=state.pos, vel=state.vel)  # no feedback: a = r'' - eta
    command = Pid(PidParams(), replace(TEXTBOOK_065, thrust_max=99.0)).update(state, calm, eta)
    upward = command.thrust / TEXTBOOK_065.mass * matrix_from_quat(state.quat)[:, 2, 2]
    assert np.allclose(upward - GRAVITY + eta.acc[:, 2], setpoint.acc[:, 2], atol=1e-12)  # eq. (6) + eta


@given(seed=st.integers(0, 10_000))
def test_the_exact_inverse_points_the_thrust_along_the_wanted_force(seed: int):
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
    alone = Pid(PidParams(), TEXTBOOK_065).update(*(only(signal, 1) for signal in whole))
    for part in ("thrust", "roll", "pitch", "yaw_rate"):
        assert getattr(alone, part)[0] == getattr(all_of_them, part)[1]


def only(signal: Signal, row: int) -> Signal:
    """Return a signal of one vehicle."""
    cut = {part: getattr(signal, part)[row : row + 1] for part in signal.__dataclass_fields__ if part != "t"}
    return replace(signal, **cut)


def test_rows_are_joined_by_name_not_by_order():
    state, setpoint, eta = random_swarm(3)
    parts = ("names", "pos", "vel", "quat", "ang_vel_body", "age", "status")
    turned = replace(state, **{part: getattr(state, part)[::-1] for part in parts})
    straight = Pid(PidParams(), TEXTBOOK_065).update(state, setpoint, eta)
    crossed = Pid(PidParams(), TEXTBOOK_065).update(turned, setpoint, eta)
    assert np.array_equal(crossed.thrust, straight.thrust)


def test_thrust_keeps_the_papers_limit_and_the_rotors_limits():
    state, setpoint, eta = swarm(("cf1",))
    pull = replace(eta, acc=np.array([[0.0, 0.0, -50.0]]))
    limited = Pid(PidParams(thrust_limited=True), TEXTBOOK_065).update(state, setpoint, pull)
    assert limited.thrust[0] == 6.6
    assert limited.status[0] == CommandStatus.SATURATED
    assert Pid(PidParams(), TEXTBOOK_065).update(state, setpoint, pull).thrust[0] == TEXTBOOK_065.thrust_max
    push = replace(eta, acc=np.array([[0.0, 0.0, 50.0]]))
    assert Pid(PidParams(), TEXTBOOK_065).update(state, setpoint, push).thrust[0] == 0.0


@given(seed=st.integers(0, 10_000), exact=st.booleans())
def test_the_thrust_never_leans_further_than_tilt_max(seed: int, exact: bool):
    state, setpoint, eta = random_swarm(seed)
    far = replace(setpoint, pos=setpoint.pos * 100.0)
    command = Pid(PidParams(exact_inverse=exact), TEXTBOOK_065).update(state, far, eta)
    lean = np.arccos(np.cos(command.roll) * np.cos(command.pitch))
    assert lean.max() <= PidParams().tilt_max + 1e-9  # rounding of arccos near 1


def test_a_repeated_stamp_gets_the_same_answer_and_changes_no_memory():
    first, second = Pid(PidParams(k_i_z=1.0), TEXTBOOK_065), Pid(PidParams(k_i_z=1.0), TEXTBOOK_065)
    for k in range(3):
        state, setpoint, eta = swarm(("cf1",), k * DT)
        setpoint = replace(setpoint, pos=np.array([[0.0, 0.0, 0.1]]))
        once = first.update(state, setpoint, eta)
        assert np.array_equal(first.update(state, setpoint, eta).thrust, once.thrust)
        assert np.array_equal(second.update(state, setpoint, eta).thrust, once.thrust)


def test_a_stamp_that_goes_back_forgets_the_integral():
    pid, thrusts = Pid(PidParams(k_i_z=1.0), TEXTBOOK_065), []
    for k in (0, 10, 20, 0):
        state, setpoint, _ = swarm(("cf1",), k * DT)
        low = replace(state, pos=np.array([[0.0, 0.0, -0.1]]))
        thrusts.append(pid.update(low, setpoint, None).thrust[0])
    assert thrusts[2] > thrusts[0]
    assert thrusts[3] == thrusts[0]


@pytest.mark.parametrize("part", ["pos", "vel", "quat"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e300])
def test_a_vehicle_with_a_bad_state_holds_then_levels_and_the_others_fly_on(part: str, bad: float):
    pid, names = Pid(PidParams(hold_time=0.03), TEXTBOOK_065), ("cf1", "cf2")
    push = replace(swarm(names)[1], acc=np.full((2, 3), 0.5))
    good = pid.update(swarm(names)[0], push, None)
    statuses = []
    for k in range(1, 6):
        state = swarm(names, k * DT)[0]
        broken = getattr(state, part).copy()
        broken[0, 0] = bad
        command = pid.update(replace(state, **{part: broken}), replace(push, t=k * DT), None)
        statuses.append(int(command.status[0]))
        assert command.thrust[1] == good.thrust[1]
        assert np.isfinite([command.thrust, command.roll, command.pitch, command.yaw_rate]).all()
        if statuses[-1] == CommandStatus.HOLD:
            assert command.pitch[0] == good.pitch[0]
    hold, level = int(CommandStatus.HOLD), int(CommandStatus.LEVEL)
    assert statuses == [hold, hold, hold, level, level]
    assert (command.thrust[0], command.roll[0], command.pitch[0]) == (TEXTBOOK_065.hover_thrust, 0.0, 0.0)


def test_a_lost_vehicle_or_one_without_state_or_a_nan_setpoint_is_not_flown_on():
    names = ("cf1", "cf2", "cf3")
    state, setpoint, eta = swarm(names)
    lost = replace(state, status=np.array([TrackStatus.LOST, 0, 0], np.uint8))
    nan_setpoint = replace(setpoint, pos=np.array([[0, 0, 0], [np.nan, 0, 0], [0, 0, 0]]))
    command = Pid(PidParams(), TEXTBOOK_065).update(lost, nan_setpoint, eta)
    assert list(command.status) == [CommandStatus.LEVEL, CommandStatus.LEVEL, CommandStatus.OK]
    missing = Pid(PidParams(), TEXTBOOK_065).update(only(state, 2), setpoint, eta)
    assert list(missing.status) == [CommandStatus.LEVEL, CommandStatus.LEVEL, CommandStatus.OK]


def test_a_downwash_that_is_not_a_number_is_ignored():
    state, setpoint, eta = swarm(("cf1", "cf2"))
    broken = replace(eta, acc=np.array([[0.0, 0.0, np.nan], [0.0, 0.0, -0.3]]))
    command = Pid(PidParams(), TEXTBOOK_065).update(state, setpoint, broken)
    hover = TEXTBOOK_065.hover_thrust
    assert command.thrust == pytest.approx([hover, hover + 0.3 * TEXTBOOK_065.mass])


def test_integrals_stay_with_their_names_when_vehicles_come_and_go():
    pid = Pid(PidParams(k_i_z=1.0), TEXTBOOK_065)
    for k, names in enumerate([("cf1",), ("cf1",), ("cf2", "cf1"), ("cf1",)]):
        state, setpoint, _ = swarm(names, k * DT)
        error = np.where(np.array(names)[:, None] == "cf1", [[0.0, 0.0, 0.1]], 0.0)
        command = pid.update(state, replace(setpoint, pos=error), None)
    lift = command.thrust[0] / TEXTBOOK_065.mass - GRAVITY
    assert lift == pytest.approx(PidParams().k_p_z * 0.1 + 2 * DT * 0.1)  # two steps before this one


def recovery_from_a_downwash_beyond_the_limit(k_i_z: float) -> Array:
    """Return the height of a vehicle that 0.6 m/s^2 press down for 2 s; 6.6 N leave it 0.344 m/s^2."""
    params = PidParams(k_p_z=4.0, k_d_z=4.0, k_i_z=k_i_z, thrust_limited=True)
    pid, height, climb, seen = Pid(params, TEXTBOOK_065), 0.0, 0.0, []
    for k in range(2000):
        state, setpoint, _ = swarm(("cf1",), k * DT)
        state = replace(state, pos=np.array([[0, 0, height]]), vel=np.array([[0, 0, climb]]))
        downwash = -0.6 if k < 200 else 0.0
        acc = pid.update(state, setpoint, None).thrust[0] / TEXTBOOK_065.mass - GRAVITY + downwash
        height, climb = height + DT * climb, climb + DT * acc
        seen.append(height)
    return np.array(seen)


def test_seconds_of_saturation_wind_nothing_up():
    without, integrating = (recovery_from_a_downwash_beyond_the_limit(k_i) for k_i in (0.0, 1.0))
    # integrating all the while would store 1.0 m s of error, 1 m/s^2, and overshoot by half the dip
    assert integrating.max() < without.max() + 0.2 * abs(without.min())
    assert abs(integrating[-1]) < 0.01 * abs(without.min())


def test_yaw_turns_the_short_way_round_within_its_rate():
    state, setpoint, eta = swarm(("cf1",))
    turned = replace(state, quat=quat_from_euler([0.0], [0.0], [3.0]))
    demanded = replace(setpoint, yaw=np.array([-3.0]))
    command = Pid(PidParams(), TEXTBOOK_065).update(turned, demanded, eta)
    assert command.yaw_rate[0] == pytest.approx(PidParams().k_yaw * (2.0 * np.pi - 6.0))
    away = Pid(PidParams(), TEXTBOOK_065).update(state, replace(setpoint, yaw=np.array([3.0])), eta)
    assert away.yaw_rate[0] == PidParams().yaw_rate_max
