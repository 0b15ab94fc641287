"""Remember each vehicle's last command, and answer with it when a tick brings no usable state.

| vehicle's last computed command is | command | status |
|---|---|---|
| at most hold_time old | that command again | HOLD |
| older, or there is none | level attitude, hover thrust, no yaw rate | LEVEL |

Ages are differences of stamps, so a replayed flight answers alike. This is about single vehicles of a tick
that came; q2q_control.fallback is about ticks that do not come.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.alignment import Aligned
from q2q_model.signals import Array, CommandStatus, Names, Status, SwarmCommand, index_of


@dataclass(frozen=True, slots=True)
class HoldThenLevel:
    """Hold what the fallback commands."""

    hold_time: float
    """[s]"""
    hover_thrust: float
    """[N]"""


class RowMemory:
    """Hold the last computed command of every vehicle and when it was computed."""

    def __init__(self, rule: HoldThenLevel) -> None:
        self.rule = rule
        self.reset()

    def reset(self) -> None:
        """Forget all commands."""
        self._names: Names = ()
        self._values = np.zeros((0, 4))  # thrust roll pitch yaw_rate
        self._stamps = np.zeros(0)

    def completed(self, tick: Aligned, values: Array, saturated: NDArray[np.bool_]) -> SwarmCommand:
        """Return the tick's command: `values` thrust, roll, pitch, yaw rate (n, 4) where usable."""
        if tick.names != self._names:
            self._reorder(tick.names)
        status = np.where(saturated, CommandStatus.SATURATED, CommandStatus.OK).astype(np.uint8)
        if tick.usable.all():
            self._values = values
            self._stamps.fill(tick.t)
            return _command(tick, values, status)
        self._values = np.where(tick.usable[:, None], values, self._values)
        self._stamps = np.where(tick.usable, tick.t, self._stamps)
        return self._without(tick, status)

    def _without(self, tick: Aligned, status: Status) -> SwarmCommand:
        old = tick.t - self._stamps > self.rule.hold_time
        level = np.array([self.rule.hover_thrust, 0.0, 0.0, 0.0])
        values = np.where((~tick.usable & old)[:, None], level, self._values)
        fallback = np.where(old, CommandStatus.LEVEL, CommandStatus.HOLD)
        return _command(tick, values, np.where(tick.usable, status, fallback).astype(np.uint8))

    def _reorder(self, names: Names) -> None:
        rows = index_of(names, self._names)
        values = np.vstack([self._values, np.zeros((1, 4))])  # row -1 is a vehicle never seen
        stamps = np.append(self._stamps, -np.inf)
        self._names, self._values, self._stamps = names, values[rows], stamps[rows]


def _command(tick: Aligned, values: Array, status: Status) -> SwarmCommand:
    thrust, roll, pitch, yaw_rate = values.T.copy()
    return SwarmCommand(tick.t, tick.names, thrust, roll, pitch, yaw_rate, status)
