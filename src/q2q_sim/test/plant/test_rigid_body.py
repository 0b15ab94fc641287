"""Accelerations of the plant are equations (1)-(9) of the paper, with body rates for the primed angles.

The angles are roll, pitch, yaw (the paper's text says pitch, yaw, roll); U4 is a torque, so b3 = 1/Izz.
"""

import numpy as np
import pytest
from numpy import cos, sin

from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY, TEXTBOOK_065, Vehicle
from q2q_sim.plant.body.rigid_body import acceleration, rate_after
from q2q_sim.plant.body.rotors import rotor_torque

ROUNDING = 1e-12
"""A few operations; relative, or on accelerations of order 10 m/s^2."""


@pytest.mark.parametrize("seed", range(20))
def test_acceleration_is_that_of_equations_4_to_9(seed: int) -> None:
    rng = np.random.default_rng(seed)
    phi, theta, psi = rng.uniform(-3.0, 3.0, 3)
    rotors, eta, mass = rng.uniform(0.0, 0.15, 4), rng.normal(size=3), CRAZYFLIE_2_0.mass
    u_x = cos(phi) * sin(theta) * cos(psi) + sin(phi) * sin(psi)
    u_y = cos(phi) * sin(theta) * sin(psi) - sin(phi) * cos(psi)
    direction = np.array([u_x, u_y, cos(phi) * cos(theta)])
    expected = rotors.sum() / mass * direction + eta - np.array([0.0, 0.0, GRAVITY])
    quat = quat_from_euler(phi, theta, psi)
    found = acceleration(tuple(quat.tolist()), tuple(rotors.tolist()), tuple(eta.tolist()), mass)
    np.testing.assert_allclose(found, expected, atol=100.0 * ROUNDING)  # up to 20 m/s^2 a factor


@pytest.mark.parametrize("vehicle", [CRAZYFLIE_2_0, TEXTBOOK_065], ids=lambda vehicle: vehicle.name)
def test_angular_acceleration_is_that_of_equations_1_to_3(vehicle: Vehicle) -> None:
    rng = np.random.default_rng(1)
    (p, q, r), rotors, step = rng.normal(size=3), rng.uniform(0.0, 0.15, 4), 0.002
    lever, drag = vehicle.arm / np.sqrt(2.0), vehicle.drag_to_thrust
    u2, u3 = np.array([[-1.0, -1.0, 1.0, 1.0], [-1.0, 1.0, 1.0, -1.0]]) @ rotors / np.sqrt(2.0)  # [N]
    u4 = drag * np.array([-1.0, 1.0, -1.0, 1.0]) @ rotors  # [N m]
    (ixx, iyy, izz), arm = vehicle.inertia, vehicle.arm
    a1, a3, a5 = (iyy - izz) / ixx, (izz - ixx) / iyy, (ixx - iyy) / izz
    b1, b2, b3 = arm / ixx, arm / iyy, 1.0 / izz
    expected = q * r * a1 + b1 * u2, p * r * a3 + b2 * u3, p * q * a5 + b3 * u4
    torque = rotor_torque(tuple(rotors.tolist()), lever, drag)
    after = rate_after((p, q, r), torque, vehicle.inertia, step)
    np.testing.assert_allclose((np.array(after) - [p, q, r]) / step, expected, rtol=1e3 * ROUNDING)
