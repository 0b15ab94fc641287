"""Tests of the vehicles of a room: thrust, motors, drag and gain, each against its closed form."""

import math

import numpy as np
import pytest
from room_flights import HOVER, JET, swarm_in

from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.air.air_terms import GroundTerm, RateLoadTerm, ResidualTerm, RotorDragTerm, VehicleTerm
from q2q_sim.air.room_air import RoomAir
from q2q_sim.plant.body.state_row import QUAT, RATE, ROTOR_MAX1, ROTORS, VEL
from q2q_sim.plant.swarm import PHYSICS_RATE


def test_ground_effect_multiplies_the_thrust() -> None:
    air = RoomAir(ground=GroundTerm(coefficient=0.5, rotor_radius_m=0.023, lowest_m=0.05))
    for z in (0.05, 0.1, 0.5):
        eta = swarm_in(air, [(0.0, 0.0, z)]).downwash()[0]
        np.testing.assert_allclose(eta, [0.0, 0.0, 0.5 * (0.023 / z) ** 2 * GRAVITY], rtol=1e-9)
    on_ground = swarm_in(air, [(0.0, 0.0, 0.01)]).downwash()[0, 2]
    assert on_ground == pytest.approx(0.5 * (0.023 / 0.05) ** 2 * GRAVITY, rel=1e-9)


def test_the_largest_thrust_falls_with_the_battery() -> None:
    own = VehicleTerm(0.0, 0.0, thrust_lag_s=0.01, headroom=1.2, headroom_per_volt=0.5, discharge_v_per_s=0.2)
    swarm = swarm_in(RoomAir(vehicle=own), [(0.0, 0.0, 1.0)])
    drive = np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]])
    full = np.tile([2.0 * HOVER, 0.0, 0.0, 0.0], (PHYSICS_RATE, 1, 1))
    swarm.step(full, drive)
    # follows 1.2 - 0.1 t with 0.01 s of lag, so by 0.001 above it
    assert swarm.state[0, ROTORS].sum() / HOVER == pytest.approx(1.1 + 0.001, abs=3e-4)


def test_a_vehicle_whose_attitude_is_asked_to_jump_gives_no_more_than_its_largest_thrust() -> None:
    """Pitch is asked for 0.3 rad forth and back at 100 Hz, with hardly any thrust: it gave three weights."""
    own = VehicleTerm(0.0, 0.0, thrust_lag_s=0.1, headroom=1.9, headroom_per_volt=0.0, discharge_v_per_s=0.0)
    swarm = swarm_in(RoomAir(vehicle=own), [(0.0, 0.0, 5.0)])
    given = []
    for k in range(100):
        command = np.array([0.05 * HOVER, 0.0, 0.3 if k % 2 else -0.3, 0.0])
        swarm.step(np.tile(command, (5, 1, 1)), np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]]))
        given.append(swarm.state[0, ROTORS].sum() / HOVER)
    assert max(given) <= 1.9


def test_a_rooms_thrust_lag_replaces_the_vehicles() -> None:
    own = VehicleTerm(0.0, 0.0, 0.04, headroom=9.0, headroom_per_volt=0.0, discharge_v_per_s=0.0)
    swarm = swarm_in(RoomAir(vehicle=own), [(0.0, 0.0, 1.0)])
    command = np.tile([1.2 * HOVER, 0.0, 0.0, 0.0], (20, 1, 1))
    swarm.step(command, np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]]))
    assert swarm.state[0, ROTORS].sum() / HOVER == pytest.approx(1.2 - 0.2 * math.exp(-1.0), rel=1e-6)


def test_motors_of_a_room_give_all_of_their_headroom() -> None:
    own = VehicleTerm(0.0, 0.0, 0.01, headroom=1.8, headroom_per_volt=0.0, discharge_v_per_s=0.0)
    swarm = swarm_in(RoomAir(vehicle=own), [(0.0, 0.0, 1.0)])
    for asked, given in ((1.7, 1.7), (2.5, 1.8)):  # the vehicle's own limit is below 1.7
        command = np.tile([asked * HOVER, 0.0, 0.0, 0.0], (PHYSICS_RATE, 1, 1))
        swarm.step(command, np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]]))
        assert swarm.state[0, ROTORS].sum() / HOVER == pytest.approx(given, rel=1e-9)


def test_the_headroom_differs_between_vehicles_by_its_deviation() -> None:
    own = VehicleTerm(0.0, 0.0, 0.05, 1.8, 0.0, 0.0, headroom_std=0.1)
    swarm = swarm_in(RoomAir(vehicle=own), [(float(k), 0.0, 1.0) for k in range(1000)])
    swarm.downwash()
    headroom = 4.0 * swarm.state[:, ROTOR_MAX1] / HOVER
    assert headroom.mean() == pytest.approx(1.8, abs=5.0 * 0.1 / np.sqrt(1000.0))
    assert headroom.std() == pytest.approx(0.1, rel=0.11)  # five deviations


def test_the_motors_of_a_vehicle_differ_by_their_deviation() -> None:
    own = VehicleTerm(0.0, 0.0, 0.05, 1.8, 0.0, 0.0, motor_std=0.08)
    swarm = swarm_in(RoomAir(vehicle=own), [(float(k), 0.0, 1.0) for k in range(1000)])
    swarm.downwash()
    work = 1.8 * 0.25 * HOVER / swarm.state[:, ROTOR_MAX1:]  # what each works at hover, over their mean
    np.testing.assert_allclose(work.mean(axis=1), 1.0)
    assert np.sqrt(((work - 1.0) ** 2).sum() / 3000.0) == pytest.approx(0.08, rel=0.07)  # five deviations


def test_turning_takes_from_the_range_of_the_rotors_that_turn_the_vehicle() -> None:
    own = VehicleTerm(0.0, 0.0, 0.07, 1.8, 0.0, 0.0)
    swarm = swarm_in(RoomAir(vehicle=own, rate_load=RateLoadTerm(3e-3)), [(0.0, 0.0, 1.0), (2.0, 0.0, 1.0)])
    swarm.state[0, RATE] = [0.5, -0.2, 1.0]
    swarm.state[1, ROTORS] = 0.25 * HOVER + np.array([-0.01, -0.01, 0.01, 0.01])  # rolls faster and faster
    swarm.downwash()
    lever = CRAZYFLIE_2_0.arm / math.sqrt(2.0)
    free, each = 0.25 * 1.8 * HOVER, 3e-3 / (4.0 * lever)
    roll, pitch = np.array([-1.0, -1.0, 1.0, 1.0]), np.array([-1.0, 1.0, 1.0, -1.0])
    np.testing.assert_allclose(swarm.state[0, ROTOR_MAX1:], free - each * (0.5 * roll - 0.2 * pitch))
    ahead = 0.07 * lever * 0.04 / CRAZYFLIE_2_0.inertia[0]  # of the rate, after the lag of the thrust
    np.testing.assert_allclose(swarm.state[1, ROTOR_MAX1:], free - each * ahead * roll)


def test_each_vehicle_feels_a_wake_by_its_own_gain() -> None:
    places = [(3.0 * k, 0.0, z) for k in range(400) for z in (0.6, 1.0)]
    swarm = swarm_in(RoomAir(jet=JET, residual=ResidualTerm(0.0, 0.0, 0.1, gain_std=0.15)), places)
    mean = swarm_in(RoomAir(jet=JET), places).downwash()[::2, 2]
    gain = swarm.downwash()[::2, 2] / mean
    assert gain.mean() == pytest.approx(1.0, abs=5.0 * 0.15 / 20.0)
    assert gain.std() == pytest.approx(0.15, rel=0.18)  # five deviations


def test_rotor_drag_slows_across_the_thrust_alone() -> None:
    swarm = swarm_in(RoomAir(rotor_drag=RotorDragTerm(0.4)), [(0.0, 0.0, 1.0), (2.0, 0.0, 1.0)])
    tilt = 0.3
    swarm.state[1, QUAT] = quat_from_euler(0.0, tilt, 0.0)
    swarm.state[:, VEL] = [1.0, -0.5, 0.2]
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    across = np.array([1.0, -0.5, 0.2]) - axis * (axis @ [1.0, -0.5, 0.2])
    np.testing.assert_allclose(swarm.downwash(), -0.4 * np.array([[1.0, -0.5, 0.0], across]), atol=1e-12)
