"""Model of the command path: thrust produced by earlier commands, and commands in transit.

A command of the tick s acts from s + latency on, and thrust follows it with a lag:

    f' = (f_c - f) / T                     f_c: the command in effect
    a  = f / m R(q) e_z - g e_z            acceleration by thrust, with the measured attitude

So the present acceleration is known without differentiation, and so is that of the commands in transit, until
a command sent now takes effect: `Actuation.pending`.

| symbol | name | meaning [unit] |
|---|---|---|
| f | thrust | collective thrust now [N], (n,) |
| T | lag | thrust behind its command [s] |
| a | acc | acceleration by thrust [m/s^2], world, (n, 3) |
"""

import math
from dataclasses import dataclass

import numpy as np

from q2q_control.disturbance.thrust_acceleration import thrust_acc_of_command
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Names, SwarmCommand, rows_by_name
from q2q_model.vehicle.constants import Vehicle

LONGEST_GAP = 0.5
"""Time between ticks [s] beyond which the past is forgotten."""


@dataclass(frozen=True, slots=True)
class SentCommand:
    """Command of one tick."""

    t: float
    """Stamp of the tick [s]."""
    thrust: Array
    """[N], (n,)."""
    acc: Array
    """Commanded acceleration [m/s^2], world, (n, 3)."""


@compiled
def follow_command(thrust: Array, impulse: Array, command: Array, part: tuple[float, float, float]) -> None:
    """Let the thrust follow a command [N] for a time, and add to its impulse [N s], (n,) each.

    `part` is that time [s], the lag of the thrust [s], and the share of the thrust's difference from its
    command that is left in the end [-].
    """
    seconds, lag, keep = part
    for v in range(thrust.size):
        rest = thrust[v] - command[v]
        impulse[v] += command[v] * seconds + rest * lag * (1.0 - keep)
        thrust[v] = command[v] + keep * rest


class Actuation:
    """Commands in transit, and the thrust that earlier ones have produced."""

    def __init__(self, vehicle: Vehicle, latency: float) -> None:
        """Model vehicles like `vehicle` whose commands act `latency` [s] after their tick's stamp."""
        self._vehicle = vehicle
        self._latency = latency
        self.reset()

    def reset(self) -> None:
        """Forget all commands; the vehicles are assumed to hover."""
        self._names: Names = ()
        self._sent: list[SentCommand] = []
        self._t = -np.inf
        self.thrust = self.mean_thrust = np.zeros(0)

    def advance(self, t: float, names: Names) -> None:
        """Let the thrust follow its commands until t [s]."""
        if names != self._names:
            self._reorder(names)
        if not 0.0 <= t - self._t <= LONGEST_GAP:
            self._sent, self._t = [], t
            self.thrust = np.full(len(names), self._vehicle.hover_thrust)
        lag, elapsed = self._vehicle.thrust_lag, t - self._t
        impulse = np.zeros(len(names))
        for seconds, sent in self._acting(self._t, t):
            keep = math.exp(-seconds / lag) if lag > 0.0 else 0.0
            follow_command(self.thrust, impulse, sent.thrust, (seconds, lag, keep))
        self._t = t
        self.mean_thrust = impulse / elapsed if self._sent and elapsed > 0.0 else self.thrust

    def pending(self) -> list[tuple[float, SentCommand]]:
        """Return the commands in effect until one sent now takes over, in order, with their durations [s]."""
        return self._acting(self._t, self._t + self._latency)

    def sent(self, command: SwarmCommand, quat: Array) -> None:
        """Remember a command of the tick last advanced to; `quat` (n, 4) gives the vehicles' yaw."""
        rows = command.thrust, command.roll, command.pitch
        acc = thrust_acc_of_command(rows, np.ascontiguousarray(quat), self._vehicle.mass)
        self._sent.append(SentCommand(self._t, command.thrust, acc))
        while len(self._sent) > 1 and self._sent[1].t + self._latency <= self._t:
            self._sent.pop(0)  # the next one is in effect already

    def _acting(self, start: float, end: float) -> list[tuple[float, SentCommand]]:
        """Return the commands in effect between two times, in order, with their durations [s]."""
        parts: list[tuple[float, SentCommand]] = []
        for k, sent in enumerate(self._sent):
            begins = sent.t + self._latency if k > 0 else -np.inf
            ends = self._sent[k + 1].t + self._latency if k + 1 < len(self._sent) else np.inf
            seconds = min(end, ends) - max(start, begins)
            if seconds > 0.0:
                parts.append((seconds, sent))
        return parts

    def _reorder(self, names: Names) -> None:
        have, hover = self._names, self._vehicle.hover_thrust  # a new vehicle hovers
        self._sent = [
            SentCommand(
                sent.t,
                rows_by_name(sent.thrust, have, names, hover),
                rows_by_name(sent.acc, have, names),
            )
            for sent in self._sent
        ]
        self.thrust, self._names = rows_by_name(self.thrust, have, names, hover), names
