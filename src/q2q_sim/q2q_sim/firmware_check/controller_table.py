"""Comparison of controllers: one row is one step of 2 ms; the position PID runs in every fifth."""

from typing import NamedTuple

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.firmware.controllers.attitude_pid import cascade
from q2q_sim.firmware.controllers.choice import FirmwareController
from q2q_sim.firmware.controllers.columns import (
    CONTROL,
    MEMORY_WIDTH,
    MOTOR_COMMAND,
    SET_BODY,
    SETPOINT_WIDTH,
    frame_row,
)
from q2q_sim.firmware.controllers.mellinger import mellinger
from q2q_sim.firmware.controllers.mixer import cap, mix
from q2q_sim.firmware.firmware_tick import STEPS
from q2q_sim.firmware.motors.airframe import airframe_of
from q2q_sim.firmware.parameters.parameter_table import TABLE
from q2q_sim.firmware.parameters.parameter_values import Parameters
from q2q_sim.firmware_check.table_rows import CheckRow, CheckTable, cases, row_numbers
from q2q_sim.plant.body.state_row import POS, QUAT, RATE, STATE_WIDTH, VEL

SETPOINT = (
    "s_mx", "s_my", "s_mz", "s_mroll", "s_mpitch", "s_myaw", "s_mquat",
    "s_px", "s_py", "s_pz", "s_vx", "s_vy", "s_vz", "s_ax", "s_ay", "s_az",
    "s_aroll", "s_apitch", "s_ayaw", "s_rroll", "s_rpitch", "s_ryaw",
    "s_q0", "s_q1", "s_q2", "s_q3", "s_thrust", "s_body",
)  # fmt: skip
"""In the order of columns.setpoint_row."""
NO_DRIFT = np.zeros(6)


class ControllerDifference(NamedTuple):
    """Largest differences of controllers."""

    cases: int
    max_pwm: float
    """Of roll, pitch, yaw and thrust."""
    max_motor_pwm: float
    """Without battery compensation."""


def compare_controllers(table: CheckTable) -> ControllerDifference:
    """Return the largest differences over all cases of controllers.csv."""
    gains = _stock_gains()
    worst = np.array([_worst(rows, gains) for rows in cases(table)])  # (cases, 2)
    return ControllerDifference(len(worst), float(worst[:, 0].max()), float(worst[:, 1].max()))


def _stock_gains() -> Array:
    """Return the gains of the stock build, (GAIN_WIDTH,): its own mass, not that of our vehicle."""
    stock = Parameters(airframe_of(CRAZYFLIE_2_0))
    for one in TABLE:
        stock.set(one.name, one.default)
    return stock.gains()


def _worst(rows: list[CheckRow], gains: Array) -> tuple[float, float]:
    memory, frame = np.zeros(MEMORY_WIDTH), frame_row(airframe_of(CRAZYFLIE_2_0))
    worst = np.zeros(2)
    for row in rows:
        _step(row, gains, memory)
        mix(memory, frame)
        duties = memory[MOTOR_COMMAND : MOTOR_COMMAND + 4].copy()
        cap(duties, 0.0)
        control = memory[CONTROL : CONTROL + 4] - row_numbers(row, ("roll", "pitch", "yaw", "thrust"))
        motors = duties - row_numbers(row, ("m1", "m2", "m3", "m4"))
        worst = np.maximum(worst, (np.abs(control).max(), np.abs(motors).max()))
    return float(worst[0]), float(worst[1])


def _step(row: CheckRow, gains: Array, memory: Array) -> None:
    state, setpoint = np.zeros(STATE_WIDTH), np.zeros(SETPOINT_WIDTH)
    state[POS], state[VEL] = row_numbers(row, ("px", "py", "pz")), row_numbers(row, ("vx", "vy", "vz"))
    state[QUAT], state[RATE] = row_numbers(row, ("qx", "qy", "qz", "qw")), row_numbers(row, ("p", "q", "r"))
    setpoint[: SET_BODY + 1] = row_numbers(row, SETPOINT)
    if int(row["controller"]) == FirmwareController.MELLINGER:
        mellinger(state, NO_DRIFT, setpoint, gains, memory)
    else:
        cascade((state, NO_DRIFT, setpoint), gains, memory, int(row["step"]) % STEPS == 0)
