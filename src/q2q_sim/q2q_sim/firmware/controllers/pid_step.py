"""Step of one of the firmware's PIDs, compiled.

Source: firmware: utils/src/pid.c, utils/src/filter.c (lpf2p, second order Butterworth).

    e = setpoint - measured,  u = k_p e + k_i int(e) + k_d d(-measured)/dt,  |int(e)| <= limit

The derivative acts on the measurement, which avoids setpoint kick, and is filtered as in the firmware: for
position and velocity (20 Hz), not for attitude and rates. `at` is the first column of a PID in one vehicle's
`memory` (columns.py); units are those of what it controls.
"""

import math
from typing import NamedTuple

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array

INTEGRAL_LIMIT = 5000.0
"""DEFAULT_PID_INTEGRATION_LIMIT of pid.h."""
_OHM = math.tan(math.pi * 20.0 / 100.0)
"""Cutoff 20 Hz at 100 Hz: PID_POS_XY_FILT_CUTOFF and others."""
_C = 1.0 + math.sqrt(2.0) * _OHM + _OHM * _OHM
_B0 = _OHM * _OHM / _C
_A1, _A2 = 2.0 * (_OHM * _OHM - 1.0) / _C, (1.0 - math.sqrt(2.0) * _OHM + _OHM * _OHM) / _C


class PidColumns(NamedTuple):
    """Where a PID stands in memory and gains, its step and limit."""

    memory: int
    """First column in memory."""
    gains: int
    """First column in the gains."""
    dt: float
    """[s]"""
    integral_max: float


@compiled
def slope_of(memory: Array, at: int, measured: float, dt: float) -> float:
    """Return d(-measured)/dt over `dt` [s] and store the measurement."""
    rise = memory[at + 1] - measured
    memory[at + 1] = measured
    return float(rise / dt)


@compiled
def filtered(memory: Array, at: int, sample: float) -> float:
    """Return the low-passed sample of the PID at column `at`."""
    first, second = memory[at + 2], memory[at + 3]
    newest = sample - first * _A1 - second * _A2
    memory[at + 3], memory[at + 2] = first, newest
    return float(_B0 * (newest + 2.0 * first + second))


@compiled
def pid(error: float, slope: float, memory: Array, gains: Array, columns: PidColumns) -> float:
    """Return the output u of one step, of the error e and d(-measured)/dt, `slope`."""
    at, gain = columns.memory, columns.gains
    memory[at] = min(max(memory[at] + error * columns.dt, -columns.integral_max), columns.integral_max)
    return float(gains[gain] * error + gains[gain + 1] * memory[at] + gains[gain + 2] * slope)


@compiled
def pid_reset(memory: Array, at: int, measured: float) -> None:
    """Reset the PID at column `at` at a measurement."""
    memory[at], memory[at + 1] = 0.0, measured
    memory[at + 2], memory[at + 3] = 0.0, 0.0
