"""The firmware's controllers: a second form of Mellinger's law, signs, and what closed loops do."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_control.attitude.allocation import rotor_frame, wrench_of
from q2q_model.geometry.rotations import euler_from_quat, matrix_from_quat, quat_from_euler
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY, TEXTBOOK_065, Vehicle
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.crtp.pilot import Pilot
from q2q_sim.firmware.commander.setpoint import ZERO, Mode, Setpoint
from q2q_sim.firmware.controllers.attitude_of import legacy_degrees
from q2q_sim.firmware.controllers.attitude_pid import cascade
from q2q_sim.firmware.controllers.columns import (
    CONTROL,
    I_POS,
    MEMORY_WIDTH,
    MOTOR,
    NEWTON_PER_PWM,
    PID_ROLL,
    PID_WIDTH,
    PIDS,
    Power,
    frame_row,
    fresh_memory,
    setpoint_row,
)
from q2q_sim.firmware.controllers.mellinger import mellinger
from q2q_sim.firmware.controllers.mixer import drive_motors
from q2q_sim.firmware.controllers.pid_step import filtered, pid, slope_of
from q2q_sim.firmware.firmware_tick import Controllers, fly_tick
from q2q_sim.firmware.motors.airframe import airframe_of
from q2q_sim.firmware.motors.thrust_curve import compensated, thrust_pwm
from q2q_sim.firmware.parameters.parameter_values import Parameters
from q2q_sim.plant.quadcopter import QUAT, RATE, STATE_WIDTH
from q2q_sim.plant.swarm import Swarm

PID, MELLINGER = 1, 2
Numbers = tuple[float, ...]

NO_DRIFT = np.zeros(6)
ANGLE = st.floats(-0.6, 0.6)
NUMBER = st.floats(-1.0, 1.0)
THREE = st.tuples(NUMBER, NUMBER, NUMBER)
STILL = np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]])


def parameters(vehicle: Vehicle = CRAZYFLIE_2_0, **values: float) -> Parameters:
    made = Parameters(airframe_of(vehicle))
    for name, value in values.items():
        made.set(name.replace("__", "."), value)
    return made


def row_at(pos: Numbers = ZERO, vel: Numbers = ZERO, angles: Numbers = ZERO, rates: Numbers = ZERO) -> Array:
    row = np.zeros(STATE_WIDTH)
    row[:3], row[3:6], row[QUAT], row[RATE] = pos, vel, quat_from_euler(*angles), rates
    return row


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


def torque_for(setpoint: Setpoint, row: Array, gains: Parameters) -> Array:
    """Return thrust [N] and torques [N m] that the motors are asked for."""
    memory, demanded, forces = np.zeros(MEMORY_WIDTH), setpoint_row(setpoint, Power()), np.zeros(4)
    if gains["stabilizer.controller"] == MELLINGER:
        mellinger(row, NO_DRIFT, demanded, gains.gains(), memory)
    else:
        cascade((row, NO_DRIFT, demanded), gains.gains(), memory, True)  # noqa: FBT003
    drive_motors(demanded, memory, frame_row(airframe_of(CRAZYFLIE_2_0)), forces)
    return wrench_of(forces, rotor_frame(CRAZYFLIE_2_0))


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


def test_thrust_is_the_stick_and_motors_never_leave_their_range() -> None:
    gains = parameters()
    hover = Setpoint(roll=Mode.ABS, pitch=Mode.ABS, yaw=Mode.VELOCITY, thrust_pwm=30000.0)
    thrust, *_ = torque_for(hover, row_at(), gains)
    assert thrust == pytest.approx(30000.0 / 65535.0 * 0.48, rel=1e-4)  # a duty is a whole number of 65535ths
    memory, forces = np.zeros(MEMORY_WIDTH), np.zeros(4)
    memory[CONTROL : CONTROL + 4] = 30000.0, -30000.0, 30000.0, 30000.0  # asks for 30000, 0, 90000, 0
    drive_motors(
        setpoint_row(hover, Power(supply=3.0)), memory, frame_row(airframe_of(CRAZYFLIE_2_0)), forces
    )
    assert memory[MOTOR : MOTOR + 4].max() == 65535.0
    assert memory[MOTOR : MOTOR + 4].min() == 0.0
    drive_motors(
        setpoint_row(hover, Power(motors_on=False)), memory, frame_row(airframe_of(CRAZYFLIE_2_0)), forces
    )
    np.testing.assert_array_equal(forces, 0.0)


@pytest.mark.parametrize(
    ("asked", "supply", "duty"),
    [(6999.0, 4.2, 0.0), (7000.0, 4.2, 12075.9688), (36000.0, 4.2, 35861.8281), (36000.0, 3.4, 44299.9023)],
)
def test_duty_makes_up_for_the_battery_and_a_motor_below_7000_pwm_stands_still(
    asked: float, supply: float, duty: float
) -> None:
    """The firmware's own numbers, and back: the curve gives at that duty what was asked for."""
    assert compensated(asked, supply) == pytest.approx(duty, rel=1e-6)  # theirs has 32 bits
    given = thrust_pwm(compensated(asked, supply), supply)
    assert given == pytest.approx(asked if duty else 0.0, rel=1e-9)


def test_duties_are_lowered_alike_after_compensation_and_lifted_to_the_idle_thrust() -> None:
    memory, forces = np.zeros(MEMORY_WIDTH), np.zeros(4)
    memory[CONTROL : CONTROL + 4] = 0.0, 60000.0, 0.0, 35535.0  # asks for 65535, 5535, 5535, 65535
    low = Power(supply=3.0, battery=3.0, idle_pwm=300.0)
    frame = frame_row(airframe_of(CRAZYFLIE_2_0))
    drive_motors(setpoint_row(Setpoint(), low), memory, frame, forces)
    np.testing.assert_array_equal(memory[MOTOR : MOTOR + 4], [65535.0, 300.0, 300.0, 65535.0])
    full = compensated(65535.0, 3.0)
    assert full == pytest.approx(
        67280.7266, rel=1e-6
    )  # 32 bits; more than there is: less than asked is given
    assert forces[0] / frame[NEWTON_PER_PWM] == pytest.approx(thrust_pwm(65535.0, 3.0))
    assert forces[0] / frame[NEWTON_PER_PWM] < 65535.0
    np.testing.assert_array_equal(forces[1:3], 0.0)
    drive_motors(setpoint_row(Setpoint(), Power()), memory, frame, forces)
    assert memory[MOTOR] < 65535.0
    memory[CONTROL + 3] = (
        60000.0  # asks for 90000, 30000, 30000, 90000: a full battery could, its load would not
    )
    drive_motors(setpoint_row(Setpoint(), Power()), memory, frame, forces)
    assert forces.max() == pytest.approx(CRAZYFLIE_2_0.thrust_max / 4)


def test_a_change_of_controller_starts_its_integrals_anew() -> None:
    pilot = Pilot(np.array([[0.0, 0.0, 1.0, 0.0]]))
    off = Setpoint(x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.0, 0.0, 1.2))
    pilot.fly(1.0, pilot.hold(off))
    memory, gains = pilot.firmware().rows.memory, pilot.firmware().parameters
    z, roll = PIDS + 2 * PID_WIDTH, PIDS + PID_ROLL * PID_WIDTH
    memory[roll] = 0.125
    assert memory[z] > 0.0
    gains.set("stabilizer.controller", MELLINGER)
    pilot.fly(0.5, pilot.hold(off))
    integrals = memory[I_POS : I_POS + 6].copy()
    assert integrals[2] > 0.0
    gains.set("stabilizer.controller", PID)
    pilot.firmware().tick()
    np.testing.assert_array_equal(memory[PIDS:roll], 0.0)
    assert memory[roll] == 0.125  # the attitude's PIDs go on
    np.testing.assert_array_equal(memory[I_POS : I_POS + 6], integrals)
    gains.set("stabilizer.controller", MELLINGER)
    pilot.firmware().tick()
    np.testing.assert_array_equal(memory[I_POS : I_POS + 6], 0.0)


@pytest.mark.parametrize(
    ("asked", "flies", "word"),
    [(0, PID, ""), (3, MELLINGER, "INDI"), (5, MELLINGER, "Lee"), (6, MELLINGER, "")],
)
def test_the_controller_reads_back_what_flies(grounded: Pilot, asked: int, flies: int, word: str) -> None:
    firmware = grounded.firmware()
    firmware.parameters.set("stabilizer.controller", MELLINGER)
    grounded.fly(0.01)
    firmware.parameters.set("stabilizer.controller", asked)
    firmware.tick()
    assert firmware.parameters["stabilizer.controller"] == flies
    assert (word in firmware.console) if word else not firmware.console


def flown(
    vehicle: Vehicle,
    controller: int,
    setpoint: Setpoint,
    seconds: float,
    drive: Array = STILL,
    **values: float,
) -> Swarm:
    swarm = Swarm(("cf1",), vehicle, np.array([[0.0, 0.0, 1.0, 0.0]]), WakeLaw.NONE)
    gains = parameters(vehicle, stabilizer__controller=controller, **values).gains()[None]
    rows = Controllers(
        np.tile(setpoint_row(setpoint, Power()), (1, 2, 1)), gains, fresh_memory(1),
        frame_row(airframe_of(vehicle))[None], np.zeros((1, 6)),
    )  # fmt: skip
    for _ in range(round(100 * seconds)):
        fly_tick(swarm, rows, drive)
    return swarm


@pytest.mark.parametrize("vehicle", [CRAZYFLIE_2_0, TEXTBOOK_065])
@pytest.mark.parametrize("controller", [PID, MELLINGER])
def test_both_controllers_settle_at_a_position_and_a_yaw_on_both_airframes(
    vehicle: Vehicle, controller: int
) -> None:
    there = Setpoint(
        x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.5, -0.4, 1.3), attitude_deg=(0.0, 0.0, 70.0)
    )
    swarm = flown(vehicle, controller, there, 20.0)
    # integrals of 0.05 N/(m s) leave centimetres after 20 s
    np.testing.assert_allclose(swarm.state[0, :3], there.pos, atol=0.03)
    np.testing.assert_allclose(swarm.state[0, 3:6], 0.0, atol=0.01)
    assert legacy_degrees(swarm.state[0])[2] == pytest.approx(70.0, abs=1.0)


@pytest.mark.parametrize("controller", [PID, MELLINGER])
def test_a_wanted_tilt_is_reached_with_the_signs_of_the_house(controller: int) -> None:
    tilted = Setpoint(
        roll=Mode.ABS, pitch=Mode.ABS, yaw=Mode.VELOCITY, attitude_deg=(4.0, -6.0, 0.0), thrust_pwm=46000.0
    )
    swarm = flown(CRAZYFLIE_2_0, controller, tilted, 1.5)
    roll, pitch, _ = np.degrees(euler_from_quat(swarm.state[0, QUAT]))
    assert (roll, pitch) == (pytest.approx(4.0, abs=0.5), pytest.approx(6.0, abs=0.5))
    assert swarm.state[0, 3] > 0.5  # nose down flies forward
    assert swarm.state[0, 4] < -0.3  # right side down flies to the right


@pytest.mark.parametrize("vehicle", [CRAZYFLIE_2_0, TEXTBOOK_065])
def test_acceleration_of_the_setpoint_takes_a_constant_push_out_under_mellinger_only(
    vehicle: Vehicle,
) -> None:
    push = 0.5  # [m/s^2], downwards, as downwash
    exact = 65535.0 / vehicle.full_pwm_thrust  # [1/N]: the stock value is 3 % less
    drive = STILL + np.array([0.0, 0.0, -push, 0.0, 0.0, 0.0, 0.0])
    error = {}
    for controller in (PID, MELLINGER):
        for aware in (False, True):
            here = Setpoint(
                x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.0, 0.0, 1.0),
                acc=(0.0, 0.0, push if aware else 0.0),
            )  # fmt: skip
            swarm = flown(vehicle, controller, here, 1.0, drive, ctrlMel__massThrust=exact)
            error[controller, aware] = 1.0 - swarm.state[0, 2]
    stiffness = parameters(vehicle)["ctrlMel.kp_z"] / vehicle.mass  # [1/s^2]
    # 1 s is 6 time constants of the loop less a little integral action
    assert error[MELLINGER, False] == pytest.approx(push / stiffness, rel=0.15)
    assert abs(error[MELLINGER, True]) < 0.15 * error[MELLINGER, False]  # the rotors' lag at the start
    assert error[PID, True] == error[PID, False]


def test_a_pid_sums_its_three_parts_and_stops_at_its_limits() -> None:
    gains, memory, dt = np.array([2.0, 0.5, 0.1]), np.zeros(4), 0.01
    errors = [1.0, 2.0, -0.5]
    for error in errors:
        out = pid(error, slope_of(memory, 0, -error, dt), memory, gains, (0, 0, dt, 5000.0, 0.0))
    slope = (errors[2] - errors[1]) / dt  # of minus the measurement
    assert out == pytest.approx(2.0 * errors[2] + 0.5 * sum(errors) * dt + 0.1 * slope)
    assert pid(1e9, 0.0, memory, gains, (0, 0, dt, 1.0, 7.0)) == 7.0
    assert memory[0] == 1.0  # the integral's own limit


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
