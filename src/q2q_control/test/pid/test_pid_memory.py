"""What the PID remembers: integrals by name, the last answer, and whom it holds."""

from dataclasses import replace

import numpy as np
import pytest
from pid_swarms import swarm

from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_model.signals.some_vehicles import of_vehicles
from q2q_model.signals.values import (
    Array,
    CommandStatus,
    TrackStatus,
)
from q2q_model.vehicle.constants import GRAVITY, TEXTBOOK_065

DT = 0.01
"""The house's tick [s]."""


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
    pid, names = Pid(PidParams(hold_duration=0.03), TEXTBOOK_065), ("cf1", "cf2")
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
    missing = Pid(PidParams(), TEXTBOOK_065).update(of_vehicles(state, np.array([2])), setpoint, eta)
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
