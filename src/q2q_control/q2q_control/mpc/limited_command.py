"""Commands of a tick from commanded accelerations, in one compiled call.

Thrust, roll, pitch and yaw rate within their limits (q2q_control.attitude.thrust_vector), completed by the
last ones where a vehicle is not usable (q2q_control.failsafe.last_commands).
"""

from typing import NamedTuple

import numpy as np

from q2q_control.attitude.thrust_vector import ThrustLimits, command_rows
from q2q_control.failsafe.last_commands import Last, complete_commands
from q2q_control.inputs.alignment import Aligned
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Mask, Status, SwarmCommand

TickRows = tuple[float, Array, Mask]
"""Time [s], table of q2q_control.inputs.alignment, and which of its rows are usable, (n,)."""


class CommandLaw(NamedTuple):
    """Limits of the commands, and the rule of their fallback."""

    limits: ThrustLimits
    full_thrust: float
    """Thrust from which a command counts as saturated [N]."""
    rule: tuple[float, float]
    """As that of q2q_control.failsafe.last_commands.complete_commands."""


def limited_command(tick: Aligned, acc: Array, law: CommandLaw, last: Last) -> SwarmCommand:
    """Return the command that gives accelerations (n, 3) [m/s^2], world; store it in `last`."""
    out, status = np.empty((4, len(acc))), np.empty(len(acc), np.uint8)
    write_commands((tick.t, tick.table, tick.usable), acc, law, last, (out, status))
    thrust, roll, pitch, yaw_rate = out
    return SwarmCommand(tick.t, tick.names, thrust, roll, pitch, yaw_rate, status)


@compiled
def write_commands(
    tick: TickRows, acc: Array, law: CommandLaw, last: Last, out: tuple[Array, Status]
) -> None:
    """Write commands, (4, n), and status, (n,), into `out`."""
    t, table, usable = tick
    values, saturated = command_rows(acc, table, law.limits)
    for v in range(usable.size):
        saturated[v] = saturated[v] or values[v, 0] >= law.full_thrust
    complete_commands((t, usable), (values, saturated), last, law.rule, out)
