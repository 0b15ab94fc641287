"""Repeat a vehicle's last command when a tick has no usable state of it.

| last computed command | command | status |
|---|---|---|
| at most hold_duration old | repeated | HOLD |
| older, or none | level attitude, hover thrust, no yaw rate | LEVEL |

Ages are differences of stamps, so a replayed flight gives the same commands. This covers single vehicles
missing from a tick; q2q_control.failsafe.fallback_phases covers missing ticks.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import HOLD, LEVEL, OK, SATURATED, Array, Mask, Names, Status, rows_by_name

Last = tuple[Array, Array]
"""Last computed commands: thrust [N], roll, pitch [rad], yaw rate [rad/s], (n, 4), and stamps [s], (n,)."""


@dataclass(frozen=True, slots=True)
class HoldThenLevel:
    """Commands of the fallback: hold, then level."""

    hold_duration: float
    """[s]"""
    hover_thrust: float
    """[N]"""

    @property
    def numbers(self) -> tuple[float, float]:
        """Return hold duration [s] and hover thrust [N], for compiled code."""
        return self.hold_duration, self.hover_thrust


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

    def memory(self, names: Names) -> Last:
        """Return the last computed commands of vehicles, written in place by `complete_commands`."""
        if names != self._names:
            self._reorder(names)
        return self._values, self._stamps

    def _reorder(self, names: Names) -> None:
        self._values = rows_by_name(self._values, self._names, names)
        self._stamps = rows_by_name(self._stamps, self._names, names, -np.inf)
        self._names = names


@compiled
def complete_commands(
    tick: tuple[float, Mask],
    computed: tuple[Array, Mask],
    last: Last,
    rule: tuple[float, float],
    out: tuple[Array, Status],
) -> None:
    """Complete the commands of a tick, and store the computed ones in `last`.

    Args:
        tick: time [s], and which vehicles are usable, (n,).
        computed: thrust, roll, pitch, yaw rate, (n, 4), and which are saturated, (n,).
        last: last computed commands.
        rule: hold duration [s], and hover thrust [N].
        out: written: commands, (4, n), and status, (n,).
    """
    (t, usable), (values, saturated), (commands, status) = tick, computed, out
    (last_values, stamps), (hold_duration, hover_thrust) = last, rule
    for i in range(usable.size):
        if usable[i]:
            last_values[i], stamps[i] = values[i], t
            status[i] = SATURATED if saturated[i] else OK
        elif t - stamps[i] > hold_duration:
            commands[:, i], commands[0, i] = 0.0, hover_thrust
            status[i] = LEVEL
            continue
        else:
            status[i] = HOLD
        commands[:, i] = last_values[i]
