"""Comparison of the mixer and the battery compensation, row by row."""

from typing import NamedTuple

import numpy as np

from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.firmware.controllers.columns import CONTROL, MEMORY_WIDTH, MOTOR_COMMAND, frame_row
from q2q_sim.firmware.controllers.mixer import cap, mix
from q2q_sim.firmware.motors.airframe import airframe_of
from q2q_sim.firmware.motors.thrust_curve import PWM_TOP, compensate
from q2q_sim.firmware_check.table_rows import CheckTable, row_numbers


class MixerDifference(NamedTuple):
    """Largest difference of the mixer, without battery compensation."""

    max_motor_pwm: float


class CompensationDifference(NamedTuple):
    """Largest difference of the battery compensation."""

    max_ratio: float
    """Of the duty, 0 to 1."""


def compare_mixer(table: CheckTable) -> MixerDifference:
    """Return the largest difference over all rows of mixer.csv."""
    memory, frame = np.zeros(MEMORY_WIDTH), frame_row(airframe_of(CRAZYFLIE_2_0))
    worst = 0.0
    for row in table:
        memory[CONTROL : CONTROL + 4] = row_numbers(row, ("roll", "pitch", "yaw", "thrust"))
        mix(memory, frame)
        duties = memory[MOTOR_COMMAND : MOTOR_COMMAND + 4].copy()
        cap(duties, 0.0)
        worst = max(worst, float(np.abs(duties - row_numbers(row, ("m1", "m2", "m3", "m4"))).max()))
    return MixerDifference(worst)


def compare_compensation(table: CheckTable) -> CompensationDifference:
    """Return the largest difference over all rows of compensation.csv."""
    gaps = [float(row["ratio"]) - compensate(float(row["control"]), float(row["volt"])) for row in table]
    return CompensationDifference(float(np.abs(gaps).max()) / PWM_TOP)
