"""The firmware's controllers: a second form of Mellinger's law, signs, and what closed loops do."""

import math

import numpy as np
import pytest
from firmware_rows import MELLINGER, NO_DRIFT, PID, Numbers, parameters, row_at, torque_for
from hypothesis import given, settings
from hypothesis import strategies as st

from cflib_fleet import CflibFleet
from q2q_model.geometry.rotations import matrix_from_quat
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.controllers.columns import (
    CONTROL,
    I_POS,
    MEMORY_WIDTH,
    PID_ROLL,
    PID_WIDTH,
    PIDS,
    Power,
    setpoint_row,
)
from q2q_sim.firmware.controllers.mellinger import mellinger
from q2q_sim.firmware.controllers.pid_step import PidColumns, filtered, pid, slope_of
from q2q_sim.firmware.controllers.position_pid import FilteredPid
from q2q_sim.firmware.controllers.position_pid import axis as filtered_pid
from q2q_sim.firmware.parameters.parameter_values import Parameters
from q2q_sim.plant.body.state_row import QUAT, RATE

ANGLE = st.floats(-0.6, 0.6)
NUMBER = st.floats(-1.0, 1.0)
THREE = st.tuples(NUMBER, NUMBER, NUMBER)


def vee_of_mellinger(row: Array, demanded: Setpoint, gains: Parameters) -> tuple[float, Array]:
    """Return thrust and moments [PWM] by the matrices of Mellinger and Kumar, in numpy, without memory."""

    def gain(name: str) -> float:
        return float(gains[f"ctrlMel.{name}"])

    kp = np.array([gain("kp_xy"), gain("kp_xy"), gain("kp_z")])
    kd = np.array([gain("kd_xy"), gain("kd_xy"), gain("kd_z")])
    acc = np.array(demanded.acc) + np.array([0.0, 0.0, GRAVITY])
    force = (
        gain("mass") * acc
        + kp * (np.array(demanded.pos) - row[:3])
        + kd * (np.array(demanded.vel) - row[3:6])
    )
    z = force / np.linalg.norm(force)
    yaw = math.radians(demanded.attitude_deg[2])
    y = np.cross(z, [math.cos(yaw), math.sin(yaw), 0.0])
    y /= np.linalg.norm(y)
    want = np.column_stack([np.cross(y, z), y, z])
    have = matrix_from_quat(row[QUAT])
    error = want.T @ have - have.T @ want
    e_r = np.array([error[2, 1], error[0, 2], error[1, 0]])
    e_w = np.radians(demanded.rate_deg) - row[RATE]
    k_r = np.array([gain("kR_xy"), gain("kR_xy"), gain("kR_z")])
    k_w = np.array([gain("kw_xy"), gain("kw_xy"), gain("kw_z")])
    return gain("massThrust") * float(force @ have[:, 2]), -k_r * e_r + k_w * e_w


@settings(deadline=None)  # the first example compiles
@given(
    pos=THREE,
    vel=THREE,
    acc=THREE,
    angles=st.tuples(ANGLE, ANGLE, st.floats(-3.0, 3.0)),
    yaw=st.floats(-170, 170),
)
def test_mellinger_is_the_matrix_law_where_it_has_no_memory(
    pos: Numbers, vel: Numbers, acc: Numbers, angles: Numbers, yaw: float
) -> None:
    none = {f"ctrlMel__{name}": 0.0 for name in ("ki_xy", "ki_z", "ki_m_xy", "ki_m_z", "kd_omega_rp")}
    gains = parameters(stabilizer__controller=MELLINGER, ctrlMel__kR_xy=7000.0, ctrlMel__kR_z=6000.0, **none)
    setpoint = Setpoint(
        x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.1, 0.2, 0.3), acc=acc,
        attitude_deg=(0.0, 0.0, yaw), rate_deg=(5.0, -4.0, 3.0),
    )  # fmt: skip
    row, memory = row_at(pos, vel, angles, (0.1, -0.2, 0.3)), np.zeros(MEMORY_WIDTH)
    mellinger(row, NO_DRIFT, setpoint_row(setpoint, Power()), gains.gains(), memory)
    thrust, moment = vee_of_mellinger(row, setpoint, gains)
    assert memory[CONTROL + 3] == pytest.approx(thrust, rel=1e-9)
    expected = [moment[0], -moment[1], -moment[2]] if thrust > 0.0 else [0.0, 0.0, 0.0]
    flown = memory[CONTROL : CONTROL + 3]
    np.testing.assert_allclose(flown, expected, atol=1.0)
    np.testing.assert_array_equal(flown, np.trunc(flown))  # moments are whole numbers


@pytest.mark.parametrize("controller", [PID, MELLINGER])
@pytest.mark.parametrize(("axis", "sign"), [(0, 1.0), (1, -1.0), (2, 1.0)])
def test_torques_turn_towards_the_wanted_attitude(controller: int, axis: int, sign: float) -> None:
    """Legacy pitch is nose up: minus theta; roll and yaw are as everywhere."""
    gains = parameters(stabilizer__controller=controller)
    demanded = [0.0, 0.0, 0.0]
    demanded[axis] = 5.0
    setpoint = Setpoint(
        roll=Mode.ABS, pitch=Mode.ABS, yaw=Mode.ABS, attitude_deg=tuple(demanded), thrust_pwm=33000.0
    )
    _, *torque = torque_for(setpoint, row_at(), gains)
    assert sign * torque[axis] > 1e-6
    others = [torque[k] for k in range(3) if k != axis]
    np.testing.assert_allclose(others, 0.0, atol=1e-9)


@pytest.mark.parametrize("controller", [PID, MELLINGER])
def test_torques_brake_every_rotation(controller: int) -> None:
    gains = parameters(stabilizer__controller=controller)
    level = Setpoint(roll=Mode.ABS, pitch=Mode.ABS, yaw=Mode.VELOCITY, thrust_pwm=33000.0)
    for axis in range(3):
        rates = [0.0, 0.0, 0.0]
        rates[axis] = 0.5
        _, *torque = torque_for(level, row_at(rates=tuple(rates)), gains)
        assert torque[axis] < -1e-6


def test_a_change_of_controller_starts_its_integrals_anew() -> None:
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, 0.0]]))
    off = Setpoint(x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.0, 0.0, 1.2))
    crazyflies.fly(1.0, crazyflies.hold(off))
    memory, gains = crazyflies.firmware().rows.memory, crazyflies.firmware().parameters
    z, roll = PIDS + 2 * PID_WIDTH, PIDS + PID_ROLL * PID_WIDTH
    memory[roll] = 0.125
    assert memory[z] > 0.0
    gains.set("stabilizer.controller", MELLINGER)
    crazyflies.fly(0.5, crazyflies.hold(off))
    integrals = memory[I_POS : I_POS + 6].copy()
    assert integrals[2] > 0.0
    gains.set("stabilizer.controller", PID)
    crazyflies.firmware().tick()
    np.testing.assert_array_equal(memory[PIDS:roll], 0.0)
    assert memory[roll] == 0.125  # the attitude's PIDs go on
    np.testing.assert_array_equal(memory[I_POS : I_POS + 6], integrals)
    gains.set("stabilizer.controller", MELLINGER)
    crazyflies.firmware().tick()
    np.testing.assert_array_equal(memory[I_POS : I_POS + 6], 0.0)


@pytest.mark.parametrize(
    ("asked", "flies", "word"),
    [(0, PID, ""), (3, MELLINGER, "INDI"), (5, MELLINGER, "Lee"), (6, MELLINGER, "")],
)
def test_the_controller_reads_back_what_flies(
    grounded: CflibFleet, asked: int, flies: int, word: str
) -> None:
    firmware = grounded.firmware()
    firmware.parameters.set("stabilizer.controller", MELLINGER)
    grounded.fly(0.01)
    firmware.parameters.set("stabilizer.controller", asked)
    firmware.tick()
    assert firmware.parameters["stabilizer.controller"] == flies
    assert (word in firmware.console) if word else not firmware.console


def test_a_pid_sums_its_three_parts_and_stops_at_its_limits() -> None:
    gains, memory, dt = np.array([2.0, 0.5, 0.1]), np.zeros(4), 0.01
    errors = [1.0, 2.0, -0.5]
    for error in errors:
        out = pid(error, slope_of(memory, 0, -error, dt), memory, gains, PidColumns(0, 0, dt, 5000.0))
    slope = (errors[2] - errors[1]) / dt  # of minus the measurement
    assert out == pytest.approx(2.0 * errors[2] + 0.5 * sum(errors) * dt + 0.1 * slope)
    assert pid(1e9, 0.0, memory, gains, PidColumns(0, 0, dt, 1.0)) == 2e9 + 0.5
    assert memory[0] == 1.0  # the integral's own limit
    memory = np.zeros(MEMORY_WIDTH)
    assert filtered_pid(1e9, 0.0, memory, gains, FilteredPid(0, 0, output_max=7.0, feed=1.0)) == 7.0
    assert filtered_pid(0.0, 0.0, memory, gains, FilteredPid(1, 0, output_max=7.0, feed=1.0)) == 1.0


@pytest.mark.parametrize(("hertz", "gain"), [(0.0, 1.0), (20.0, math.sqrt(0.5))])
def test_the_filter_of_derivatives_passes_slow_ones_and_halves_the_power_at_its_cutoff(
    hertz: float, gain: float
) -> None:
    memory, t = np.zeros(4), np.arange(400) / 100.0
    wave = np.exp(2j * math.pi * hertz * t)
    real = np.array([filtered(memory, 0, one) for one in wave.real])
    memory[:] = 0.0
    imaginary = np.array([filtered(memory, 0, one) for one in wave.imag])
    np.testing.assert_allclose(np.hypot(real, imaginary)[200:], gain, rtol=1e-9)  # the start has died out
