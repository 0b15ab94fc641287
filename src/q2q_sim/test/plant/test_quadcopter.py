"""Tests of one vehicle's motion against closed forms and conservation laws."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from q2q_control.attitude.attitude_law import AttitudeParams
from q2q_model.geometry.rotations import euler_from_quat, rotate
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY, TEXTBOOK_065, VEHICLES, Vehicle
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.plant.body.rotors import excess_share, share_given
from q2q_sim.plant.body.state_row import POS, QUAT, RATE, ROTORS, VEL
from q2q_sim.plant.swarm import PHYSICS_RATE, Swarm

H = 1.0 / PHYSICS_RATE
VEHICLE = pytest.mark.parametrize("vehicle", VEHICLES.values(), ids=list(VEHICLES))


def _one(vehicle: Vehicle, height: float = 100.0) -> Swarm:
    return Swarm(("cf1",), vehicle, np.array([[0.0, 0.0, height, 0.0]]), WakeLaw.NONE)


def _fly(swarm: Swarm, command: tuple[float, float, float, float], seconds: float) -> None:
    steps = round(seconds / H)
    swarm.step(np.tile(command, (steps, 1, 1)), np.array([[0.0] * 3 + [1.0] * 4]))


def _angular_momentum(swarm: Swarm, vehicle: Vehicle) -> Array:
    row = swarm.state[0]
    return rotate(row[QUAT], np.array(vehicle.inertia) * row[RATE])


@VEHICLE
def test_a_vehicle_without_thrust_falls_on_the_parabola(vehicle: Vehicle) -> None:
    swarm = _one(vehicle)
    swarm.state[0, ROTORS] = 0.0
    swarm.state[0, VEL] = [1.0, -2.0, 3.0]
    _fly(swarm, (0.0, 0.0, 0.0, 0.0), 2.0)
    fallen = np.array([2.0, -4.0, 100.0 + 3.0 * 2.0 - 0.5 * GRAVITY * 4.0])
    np.testing.assert_allclose(swarm.state[0, POS], fallen, atol=1e-10)  # rounding of 1000 sums near 100


@VEHICLE
def test_hover_thrust_hovers(vehicle: Vehicle) -> None:
    swarm = _one(vehicle, height=1.5)
    _fly(swarm, (vehicle.hover_thrust, 0.0, 0.0, 0.0), 10.0)
    np.testing.assert_allclose(swarm.state[0, POS], [0.0, 0.0, 1.5], atol=1e-9)  # rounding, twice integrated


def test_thrust_follows_its_command_with_the_vehicles_lag() -> None:
    vehicle = CRAZYFLIE_2_0
    swarm = _one(vehicle)
    before, after = vehicle.hover_thrust, 1.3 * vehicle.hover_thrust
    for seconds in (0.02, 0.05, 0.1):
        swarm = _one(vehicle)
        _fly(swarm, (after, 0.0, 0.0, 0.0), seconds)
        expected = after + (before - after) * math.exp(-seconds / vehicle.thrust_lag)
        assert swarm.state[0, ROTORS].sum() == pytest.approx(expected, rel=1e-12)  # exact discretisation


def _tilt_after_step(vehicle: Vehicle, seconds: float) -> float:
    """Return the angle of the attitude law's loop after a unit step: its linear system, solved exactly.

    phi'' + 2 zeta w phi' + w^2 phi = w^2 (1 - s): s is what the rotors' lag still lacks, s' = -s / T_lag.
    """
    params = AttitudeParams()
    w = params.frequency
    fading = 1.0 / vehicle.thrust_lag if vehicle.thrust_lag > 0.0 else 0.0
    lacking = 1.0 if vehicle.thrust_lag > 0.0 else 0.0
    system = np.array(
        [[0, 1, 0, 0], [-w * w, -2.0 * params.damping * w, -w * w, w * w], [0, 0, -fading, 0], [0, 0, 0, 0]]
    )
    return float((expm(system * seconds) @ [0.0, 0.0, lacking, 1.0])[0])


@VEHICLE
@pytest.mark.parametrize("axis", [0, 1], ids=["roll", "pitch"])
def test_tilt_answers_a_step_as_the_second_order_loop_it_is_made_to_be(vehicle: Vehicle, axis: int) -> None:
    step = 0.1
    swarm = _one(vehicle)
    tilt = (step, 0.0) if axis == 0 else (0.0, step)
    for k in range(1, 20):
        _fly(swarm, (vehicle.hover_thrust, *tilt, 0.0), 0.02)
        angle = euler_from_quat(swarm.state[0, QUAT])[axis]
        # the loop runs every 2 ms: the steepest angle, w step, times one and a half steps
        expected = step * _tilt_after_step(vehicle, 0.02 * k)
        assert angle == pytest.approx(expected, abs=1.5 * AttitudeParams().frequency * H * step)


@VEHICLE
def test_yaw_rate_settles_on_its_command(vehicle: Vehicle) -> None:
    swarm = _one(vehicle)
    _fly(swarm, (vehicle.hover_thrust, 0.0, 0.0, 0.7), 3.0)
    assert swarm.state[0, 12] == pytest.approx(0.7, rel=1e-3)  # 15 time constants of 1/5 s


@VEHICLE
def test_positive_pitch_drives_along_x_and_positive_roll_against_y(vehicle: Vehicle) -> None:
    for tilt, axis, sign in (((0.0, 0.2), 0, 1.0), ((0.2, 0.0), 1, -1.0)):
        swarm = _one(vehicle)
        _fly(swarm, (vehicle.hover_thrust, *tilt, 0.0), 1.0)
        assert sign * swarm.state[0, 3 + axis] > 1.0
        assert swarm.state[0, 4 - axis] == pytest.approx(0.0, abs=1e-9)


@VEHICLE
def test_spin_without_torque_keeps_angular_momentum_and_energy(vehicle: Vehicle) -> None:
    swarm = _one(vehicle, height=1000.0)
    swarm.state[0, ROTORS] = 0.0
    swarm.state[0, RATE] = [3.0, -2.0, 4.0]
    inertia = np.array(vehicle.inertia)
    before = _angular_momentum(swarm, vehicle)
    energy = float(inertia @ swarm.state[0, RATE] ** 2)
    _fly(swarm, (0.0, 0.0, 0.0, 0.0), 1.0)
    # first order in the step: w turns by |w| h = 1 % a step, the error of a step is half its square
    drift = np.linalg.norm(_angular_momentum(swarm, vehicle) - before) / np.linalg.norm(before)
    assert drift < 0.03
    assert float(inertia @ swarm.state[0, RATE] ** 2) == pytest.approx(energy, rel=0.03)
    assert np.abs(swarm.state[0, RATE] - [3.0, -2.0, 4.0]).max() > 0.5  # it did precess


def test_halving_the_step_halves_the_drift_of_angular_momentum() -> None:
    from q2q_sim.plant.body.quadcopter import body_of
    from q2q_sim.plant.body.state_row import state_at_rest
    from q2q_sim.plant.swarm import run_steps
    from q2q_sim.plant.swarm_air import still_air

    vehicle = TEXTBOOK_065
    drifts = []
    for step in (0.004, 0.002, 0.001):
        body = body_of(vehicle, AttitudeParams(), step)
        state = state_at_rest(np.array([[0.0, 0.0, 1000.0, 0.0]]), vehicle.mass)
        state[0, ROTORS], state[0, RATE] = 0.0, [3.0, -2.0, 4.0]
        inertia = np.array(vehicle.inertia)
        before = rotate(state[0, QUAT], inertia * state[0, RATE])
        air = still_air(state, WakeLaw.NONE, body)
        commands = np.zeros((round(1.0 / step), 1, 4))
        run_steps(state, air, commands, np.array([[0.0] * 3 + [1.0] * 4]), body)
        drifts.append(np.linalg.norm(rotate(state[0, QUAT], inertia * state[0, RATE]) - before))
    assert drifts[0] / drifts[1] == pytest.approx(2.0, rel=0.1)  # first order, higher orders 10 %
    assert drifts[1] / drifts[2] == pytest.approx(2.0, rel=0.1)


def test_fall_and_rise_exchange_energy_exactly() -> None:
    swarm = _one(CRAZYFLIE_2_0)
    swarm.state[0, ROTORS] = 0.0
    swarm.state[0, VEL] = [0.5, 0.0, 4.0]
    specific = []
    for _ in range(50):
        _fly(swarm, (0.0, 0.0, 0.0, 0.0), 0.02)
        specific.append(0.5 * float(swarm.state[0, VEL] @ swarm.state[0, VEL]) + GRAVITY * swarm.state[0, 2])
    np.testing.assert_allclose(specific, 0.5 * (0.25 + 16.0) + GRAVITY * 100.0, rtol=1e-12)


def test_a_weaker_rotor_gain_sinks_by_its_share_of_the_weight() -> None:
    vehicle, gain = TEXTBOOK_065, 0.98
    swarm = _one(vehicle)
    drive = np.array([[0.0] * 3 + [gain] * 4])
    swarm.step(np.tile([vehicle.hover_thrust, 0.0, 0.0, 0.0], (round(1.0 / H), 1, 1)), drive)
    assert swarm.state[0, 2] == pytest.approx(100.0 - 0.5 * (1.0 - gain) * GRAVITY, abs=1e-10)


def test_the_ground_stops_a_fall_and_lets_a_vehicle_rise_again() -> None:
    vehicle = CRAZYFLIE_2_0
    swarm = _one(vehicle, height=0.3)
    swarm.state[0, VEL] = [1.0, 0.0, 0.0]
    swarm.state[0, RATE] = [1.0, 1.0, 0.0]
    _fly(swarm, (0.0, 0.0, 0.0, 0.0), 1.0)
    assert swarm.state[0, 2] == 0.0
    np.testing.assert_array_equal(swarm.state[0, VEL], 0.0)
    np.testing.assert_array_equal(euler_from_quat(swarm.state[0, QUAT])[:2], 0.0)
    resting = swarm.state[0, POS].copy()
    _fly(swarm, (0.5 * vehicle.hover_thrust, 0.0, 0.0, 0.0), 0.5)
    np.testing.assert_array_equal(swarm.state[0, POS], resting)
    _fly(swarm, (1.3 * vehicle.hover_thrust, 0.0, 0.0, 0.0), 1.0)
    assert swarm.state[0, 2] > 0.5


def test_a_vehicle_on_the_ground_stays_where_it_is_in_wind() -> None:
    swarm = _one(CRAZYFLIE_2_0, height=0.0)
    start, drive = swarm.state[0, POS].copy(), np.array([[1.0, -2.0, 0.0, 1.0, 1.0, 1.0, 1.0]])
    swarm.step(np.zeros((500, 1, 4)), drive)
    np.testing.assert_array_equal(swarm.state[0, POS], start)


def test_rotors_at_their_limit_cost_thrust_and_no_torque() -> None:
    commanded, rotor_max = (0.12, 0.05, 0.09, 0.14), (0.10, 0.10, 0.10, 0.13)
    lost = excess_share(commanded, rotor_max)
    given = np.array(commanded) - lost
    assert given.sum() == pytest.approx(np.minimum(commanded, rotor_max).sum())  # cut one by one
    np.testing.assert_allclose(given - given.mean(), np.array(commanded) - np.mean(commanded))
    assert excess_share(commanded, (math.inf,) * 4) == 0.0


@pytest.mark.parametrize(
    "commanded", [(1.535, 0.0, 0.0014, 1.5456), (0.30, 0.02, 0.02, 0.30), (0.4, 0.0, 0.0, 0.0)]
)
def test_rotors_that_cannot_lose_alike_give_together_what_each_gives_by_itself(
    commanded: tuple[float, float, float, float],
) -> None:
    rotor_max = (0.155, 0.15, 0.16, 0.155)
    lost = excess_share(commanded, rotor_max)
    given = share_given(commanded, rotor_max, lost) * np.maximum(np.array(commanded) - lost, 0.0)
    assert given.sum() == pytest.approx(np.minimum(commanded, rotor_max).sum(), rel=1e-12)
    assert share_given((0.12, 0.05, 0.09, 0.14), (0.10, 0.10, 0.10, 0.13), 0.0075) == 1.0
