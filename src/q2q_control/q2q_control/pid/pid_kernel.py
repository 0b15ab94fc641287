"""Law of `q2q_control.pid.pid` over the rows of a tick, in a compiled loop.

On two vehicles, numpy's calls would cost ten times the arithmetic. `table` is that of
q2q_control.inputs.alignment.
"""

import math
from typing import NamedTuple

import numpy as np

from q2q_control.attitude.thrust_vector import Excess, PlainLimits, ThrustLimits, write_command
from q2q_control.failsafe.last_commands import Last, complete_commands
from q2q_control.inputs.alignment import ETA_AT, POS_AT, REF_ACC_AT, REF_POS_AT, REF_VEL_AT, VEL_AT
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask, Status


class PidGains(NamedTuple):
    """Gains of x, y, z, (3,) each."""

    k_p: Array
    """[1/s^2]"""
    k_d: Array
    """[1/s]"""
    k_i: Array
    """[1/s^3]"""
    integral_max: Array
    """[m/s^2]"""
    error_max: tuple[float, float]
    """Largest error of position that counts, horizontal and vertical [m]."""


PidTick = tuple[float, float, Array, Mask]
"""Time, and time since the last tick [s], table, and which of its rows are usable, (n,)."""
PlainGains = tuple[Array, Array, Array, Array, tuple[float, float]]
"""Fields of PidGains, which numba takes from Python in less than half the time."""
Law = tuple[PlainGains, PlainLimits]
"""PidGains and ThrustLimits."""


@compiled
def pid_rows(
    table: Array, integral: Array, gains: PidGains, limits: ThrustLimits, dt: float
) -> tuple[Array, Mask]:
    """Return thrust [N], roll, pitch [rad], yaw rate [rad/s] (n, 4) and saturation (n,) of a table's rows.

    `integral` (n, 3) [m/s^2] advances in place by `dt` [s].
    """
    n = table.shape[0]
    values, saturated = np.empty((n, 4)), np.empty(n, np.bool_)
    acc, error = np.empty(3), np.empty(3)
    for i in range(n):
        row = table[i]
        for k in range(3):
            error[k] = row[REF_POS_AT + k] - row[POS_AT + k]
        share = _shares(error, gains.error_max)
        for k in range(3):
            acc[k] = row[REF_ACC_AT + k] + gains.k_p[k] * share[k // 2] * error[k]
            acc[k] += gains.k_d[k] * (row[REF_VEL_AT + k] - row[VEL_AT + k])
            acc[k] += integral[i, k] - row[ETA_AT + k]
        excess = write_command(acc, row, limits, values[i])
        saturated[i] = excess.tilt or excess.thrust != 0.0
        outward = acc[0] * gains.k_i[0] * error[0] + acc[1] * gains.k_i[1] * error[1]
        held = Excess(excess.thrust, excess.tilt and outward > 0.0)
        _integrate(integral[i], error, gains, (held, share), dt)
    return values, saturated


@compiled
def _shares(error: Array, most: tuple[float, float]) -> tuple[float, float]:
    """Return the shares of the horizontal and of the vertical error that count [-]."""
    side = math.sqrt(error[0] * error[0] + error[1] * error[1])
    return _share(side, most[0]), _share(abs(error[2]), most[1])


@compiled
def _share(size: float, most: float) -> float:
    """Return the share of an error of a size [m] that is left where it is cut at `most` [m], or infinite."""
    return 1.0 if size <= most else most / size


@compiled
def pid_commands(
    tick: PidTick,
    law: Law,
    memory: tuple[Array, Last],
    rule: tuple[float, float],
    out: tuple[Array, Status],
) -> None:
    """Write the commands of a tick: the law's, or the last ones where a vehicle is not usable.

    Args:
        tick: inputs.
        law: gains and limits, as plain tuples: numba takes named ones in three times the time.
        memory: integrals, (n, 3), and last computed commands; both advance.
        rule: as that of q2q_control.failsafe.last_commands.complete_commands.
        out: as there.
    """
    t, dt, table, usable = tick
    computed = pid_rows(table, memory[0], PidGains(*law[0]), ThrustLimits(*law[1]), dt)
    complete_commands((t, usable), computed, memory[1], rule, out)


@compiled
def _integrate(
    integral: Array, error: Array, gains: PidGains, limited: tuple[Excess, tuple[float, float]], dt: float
) -> None:
    """Advance the integral, but not of an error of which a share counts, nor in the direction of an excess.

    The excess is x and y's by tilt, z's by thrust.
    """
    excess, share = limited
    for k in range(3):
        step = gains.k_i[k] * error[k] * dt
        if share[k // 2] < 1.0 or (k < 2 and excess.tilt) or (k == 2 and step * excess.thrust > 0.0):
            continue
        integral[k] = min(max(integral[k] + step, -gains.integral_max[k]), gains.integral_max[k])
