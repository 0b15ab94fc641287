"""Rows of vehicles and parameters of the emulated firmware, for tests."""

import numpy as np

from q2q_control.attitude.allocation import rotor_frame, wrench_of
from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, Vehicle
from q2q_sim.firmware.commander.setpoint import ZERO, Setpoint
from q2q_sim.firmware.controllers.attitude_pid import cascade
from q2q_sim.firmware.controllers.columns import (
    MEMORY_WIDTH,
    Power,
    frame_row,
    setpoint_row,
)
from q2q_sim.firmware.controllers.mellinger import mellinger
from q2q_sim.firmware.controllers.mixer import drive_motors
from q2q_sim.firmware.motors.airframe import airframe_of
from q2q_sim.firmware.parameters.parameter_values import Parameters
from q2q_sim.plant.body.state_row import QUAT, RATE, STATE_WIDTH

PID, MELLINGER = 1, 2
Numbers = tuple[float, ...]
NO_DRIFT = np.zeros(6)
STILL = np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]])


def parameters(vehicle: Vehicle = CRAZYFLIE_2_0, **values: float) -> Parameters:
    """Return the parameters of a vehicle; `__` in a name stands for its dot."""
    made = Parameters(airframe_of(vehicle))
    for name, value in values.items():
        made.set(name.replace("__", "."), value)
    return made


def row_at(pos: Numbers = ZERO, vel: Numbers = ZERO, angles: Numbers = ZERO, rates: Numbers = ZERO) -> Array:
    """Return the state of a vehicle: position [m], velocity [m/s], roll, pitch, yaw [rad], rates [rad/s]."""
    row = np.zeros(STATE_WIDTH)
    row[:3], row[3:6], row[QUAT], row[RATE] = pos, vel, quat_from_euler(*angles), rates
    return row


def torque_for(setpoint: Setpoint, row: Array, gains: Parameters) -> Array:
    """Return thrust [N] and torques [N m] that the motors are asked for."""
    memory, demanded, forces = np.zeros(MEMORY_WIDTH), setpoint_row(setpoint, Power()), np.zeros(4)
    if gains["stabilizer.controller"] == MELLINGER:
        mellinger(row, NO_DRIFT, demanded, gains.gains(), memory)
    else:
        cascade((row, NO_DRIFT, demanded), gains.gains(), memory, True)  # noqa: FBT003
    drive_motors(demanded, memory, frame_row(airframe_of(CRAZYFLIE_2_0)), forces)
    return wrench_of(forces, rotor_frame(CRAZYFLIE_2_0))
