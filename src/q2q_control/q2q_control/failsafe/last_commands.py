"""Repeat a vehicle's last command when a tick has no usable state of it.

| last computed command | command | status |
|---|---|---|
| at most hold_time old | repeated | HOLD |
| older, or none | level attitude, hover thrust, no yaw rate | LEVEL |

Ages are differences of stamps, so a replayed flight gives the same commands. This covers single vehicles
missing from a tick; q2q_control.failsafe.ladder covers missing ticks.
"""

from dataclasses import dataclass
from typing import NamedTuple

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
        rule = _Rule(self.rule.hold_time, self.rule.hover_thrust)
        last = _Last(self._values, self._stamps)
        _complete(_Tick(tick.t, values, saturated, tick.usable), last, rule, out, status)
        return SwarmCommand(tick.t, tick.names, out[0], out[1], out[2], out[3], status)

    def _reorder(self, names: Names) -> None:
        rows = index_of(names, self._names)
        values = np.vstack([self._values, np.zeros((1, 4))])  # row -1 is a vehicle never seen
        stamps = np.append(self._stamps, -np.inf)
        self._names, self._values, self._stamps = names, values[rows], stamps[rows]


class _Tick(NamedTuple):
    """Commands computed in a tick."""

    t: float
    values: Array
    """Thrust, roll, pitch, yaw rate, (n, 4)."""
    saturated: Flags
    usable: Flags


class _Last(NamedTuple):
    """Last computed commands."""

    values: Array
    stamps: Array


class _Rule(NamedTuple):
    hold_time: float
    hover_thrust: float


@compiled
def _complete(tick: _Tick, last: _Last, rule: _Rule, out: Array, status: Status) -> None:
    """Write commands (4, n) and status (n,), and store the computed ones in `last`."""
    for i in range(tick.usable.size):
        if tick.usable[i]:
            last.values[i], last.stamps[i] = tick.values[i], tick.t
            status[i] = _SATURATED if tick.saturated[i] else _OK
        elif tick.t - last.stamps[i] > rule.hold_time:
            out[:, i], out[0, i] = 0.0, rule.hover_thrust
            status[i] = _LEVEL
            continue
        else:
            status[i] = _HOLD
        out[:, i] = last.values[i]
