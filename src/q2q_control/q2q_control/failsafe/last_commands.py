"""Repeat a vehicle's last command when a tick has no usable state of it.

| last computed command | command | status |
|---|---|---|
| at most hold_time old | repeated | HOLD |
| older, or none | level attitude, hover thrust, no yaw rate | LEVEL |

Ages are differences of stamps, so a replayed flight gives the same commands. This covers single vehicles
missing from a tick; q2q_control.failsafe.ladder covers missing ticks.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.inputs.alignment import Aligned
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, CommandStatus, Names, Status, SwarmCommand, index_of

Flags = NDArray[np.bool_]

_OK, _SATURATED = int(CommandStatus.OK), int(CommandStatus.SATURATED)
_HOLD, _LEVEL = int(CommandStatus.HOLD), int(CommandStatus.LEVEL)


@dataclass(frozen=True, slots=True)
class HoldThenLevel:
    """Commands of the fallback: hold, then level."""

    hold_time: float
    """[s]"""
    hover_thrust: float
    """[N]"""


class LastCommands:
    """Last computed command of every vehicle and its time."""

    def __init__(self, rule: HoldThenLevel) -> None:
        self.rule = rule
        self.reset()

    def reset(self) -> None:
        """Forget all commands."""
        self._names: Names = ()
        self._values = np.zeros((0, 4))  # thrust roll pitch yaw_rate
        self._stamps = np.zeros(0)

    def completed(self, tick: Aligned, values: Array, saturated: Flags) -> SwarmCommand:
        """Return the tick's command: `values` thrust, roll, pitch, yaw rate (n, 4) where usable."""
        if tick.names != self._names:
            self._reorder(tick.names)
        out, status = np.empty((4, len(values))), np.empty(len(values), dtype=np.uint8)
        fresh, kept = (values, saturated, tick.usable), (self._values, self._stamps)
        complete(fresh, kept, (tick.t, self.rule.hold_time, self.rule.hover_thrust), out, status)
        return SwarmCommand(tick.t, tick.names, out[0], out[1], out[2], out[3], status)

    def _reorder(self, names: Names) -> None:
        rows = index_of(names, self._names)
        values = np.vstack([self._values, np.zeros((1, 4))])  # row -1 is a vehicle never seen
        stamps = np.append(self._stamps, -np.inf)
        self._names, self._values, self._stamps = names, values[rows], stamps[rows]


def _complete(
    fresh: tuple[Array, Flags, Flags],
    kept: tuple[Array, Array],
    rule: tuple[float, float, float],
    out: Array,
    status: Status,
) -> None:
    values, saturated, usable = fresh
    last, stamps = kept
    t, hold_time, hover_thrust = rule
    for i in range(usable.size):
        if usable[i]:
            last[i], stamps[i] = values[i], t
            status[i] = _SATURATED if saturated[i] else _OK
        elif t - stamps[i] > hold_time:
            out[:, i], out[0, i] = 0.0, hover_thrust
            status[i] = _LEVEL
            continue
        else:
            status[i] = _HOLD
        out[:, i] = last[i]


complete = compiled(_complete)
"""Write commands (4, n) and status (n,), and store the computed ones: ((values (n, 4), saturated, usable),
(last values (n, 4), stamps (n,)), (t, hold_time, hover_thrust), commands, status)."""
