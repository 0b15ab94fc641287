"""Commands of a tick from commanded accelerations, in one compiled call.

Thrust, roll, pitch and yaw rate within their limits (q2q_control.attitude.thrust_vector), completed by the
last ones where a vehicle is not usable (q2q_control.failsafe.last_commands).
"""

from typing import NamedTuple

import numpy as np

from q2q_control.attitude.thrust_vector import PlainLimits, ThrustLimits, command_rows
from q2q_control.failsafe.last_commands import Last, complete_commands
from q2q_control.inputs.alignment import Aligned
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask, Status, SwarmCommand

TickRows = tuple[float, Array, Mask]
"""Time [s], table of q2q_control.inputs.alignment, and which of its rows are usable, (n,)."""


class CommandLaw(NamedTuple):
    """Limits of the commands, and the rule of their fallback."""

    limits: PlainLimits
    full_thrust: float
    """Thrust from which a command counts as saturated [N]."""
    rule: tuple[float, float]
    """As that of q2q_control.failsafe.last_commands.complete_commands."""


PlainLaw = tuple[PlainLimits, float, tuple[float, float]]
"""Fields of a CommandLaw, which numba takes from Python in less than half the time."""


def limited_command(tick: Aligned, acc: Array, law: PlainLaw, last: Last) -> SwarmCommand:
    """Return the command that gives accelerations (n, 3) [m/s^2], world; store it in `last`."""
    out, status = np.empty((4, len(acc))), np.empty(len(acc), np.uint8)
    write_commands((tick.t, tick.table, tick.usable), acc, law, last, (out, status))
    return SwarmCommand(tick.t, tick.names, out[0], out[1], out[2], out[3], status)


@compiled
def write_commands(tick: TickRows, acc: Array, law: PlainLaw, last: Last, out: tuple[Array, Status]) -> None:
    """Write commands, (4, n), and status, (n,), into `out`.

    `acc` (n, 3) are the accelerations asked for [m/s^2], world.
    """
    (t, table, usable), (limits, full_thrust, rule) = tick, law
    values, saturated = command_rows(acc, table, ThrustLimits(*limits))
    for v in range(usable.size):
        saturated[v] = saturated[v] or values[v, 0] >= full_thrust
    complete_commands((t, usable), (values, saturated), last, rule, out)
