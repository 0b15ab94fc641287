"""Carry commands to the vehicles as the Crazyradio does: late, at times lost, in degrees and PWM.

Each command of a tick is one RPYT packet a vehicle. It arrives `latency` (plus jitter) after the tick, or is
lost. On board, as in the Crazyflie firmware (crtp_commander_rpyt.c, commander.c):

- thrust stays locked at zero until one packet with zero thrust has come;
- 0.5 s without a packet: level, no turning, thrust as it was;
- 2 s without a packet: motors cut, and locked again;
- thrust below 1000 PWM is none, above 60000 is 60000.

Watchdogs are looked at once a tick. A packet carries angles as 32-bit floats in degrees and thrust as a whole
number of PWM; with `quantised` off it carries what was asked. Apart from q2q_control.legacy this is the only
place with degrees and PWM.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.legacy import PWM_MAX, LegacyScale, legacy_setpoints
from q2q_model.parameters import check_bounds, tunable
from q2q_model.signals import Array, SwarmCommand
from q2q_sim.episodes import Mask
from q2q_sim.streams import stream

LEVEL_AFTER_NS = 500_000_000
"""COMMANDER_WDT_TIMEOUT_STABILIZE of the firmware [ns]."""
CUT_AFTER_NS = 2_000_000_000
"""COMMANDER_WDT_TIMEOUT_SHUTDOWN of the firmware [ns]."""
PWM_MIN = 1000
"""MIN_THRUST of the firmware [PWM]."""

Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class RadioParams:
    """Hold how well commands arrive; the defaults are transparent."""

    rate: float = tunable(100.0, "packets a second and vehicle, at most", unit="Hz", low=1.0, high=100.0)
    latency: float = tunable(0.0, "command given to command obeyed", unit="s", low=0.0, high=0.5)
    jitter: float = tunable(0.0, "latency varies by up to this", unit="s", low=0.0, high=0.009)
    loss: float = tunable(0.0, "share of packets lost", low=0.0, high=1.0)
    quantised: bool = tunable(default=False, description="whole PWM and 32-bit degrees")
    unlocked: bool = tunable(default=True, description="a zero-thrust packet has come before the flight")

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


@dataclass(frozen=True, slots=True)
class _Burst:
    """Hold packets on their way that arrive together."""

    arrival_ns: int
    rows: Rows
    """Vehicles they are for, (k,)."""
    values: Array
    """Thrust [N], roll, pitch [rad], yaw rate [rad/s], (k, 4)."""


class Radio:
    """Hold the packets on their way, and what each vehicle obeys."""

    def __init__(self, params: RadioParams, at_start: Array, thrust_max: float, seed: int) -> None:
        """Start with every vehicle obeying a thrust [N] of `at_start` (n,), level."""
        n = len(at_start)
        self._params = params
        self._scale = LegacyScale(thrust_max)
        self._loss, self._jitter = stream(seed, "radio loss"), stream(seed, "radio jitter")
        self._gap_ns, self._latency_ns = round(1e9 / params.rate), round(1e9 * params.latency)
        self._next_ns = np.zeros(n, dtype=np.int64)
        self._flying: list[_Burst] = []
        self._heard_ns = np.zeros(n, dtype=np.int64)
        self._locked = np.full(n, not params.unlocked)
        self._obeyed = np.zeros((n, 4))
        self._obeyed[:, 0] = np.where(self._locked, 0.0, at_start)

    def send(self, now_ns: int, rows: Rows, command: SwarmCommand, jammed: Mask) -> None:
        """Send the command of the tick at now_ns; row k of it is for vehicle rows[k].

        Packets to vehicles that are `jammed` (n,) are lost besides those that are lost anyway.
        """
        due = self._next_ns[rows] <= now_ns
        next_ns = np.maximum(self._next_ns[rows], now_ns - self._gap_ns) + self._gap_ns
        self._next_ns[rows[due]] = next_ns[due]
        kept = np.flatnonzero(due & ~self._lost(rows) & ~jammed[rows])
        values, rows = self._coded(command)[kept], rows[kept]
        arrival_ns = now_ns + self._latency_ns
        if self._params.jitter == 0.0:
            self._flying.append(_Burst(arrival_ns, rows, values))
            return
        late = self._jitter.random(len(self._next_ns)) * (self._params.jitter * 1e9)  # [ns], one a vehicle
        self._flying += [
            _Burst(arrival_ns + round(late[row]), rows[k : k + 1], values[k : k + 1])
            for k, row in enumerate(rows.tolist())
        ]

    def obeyed(self, now_ns: int, step_ns: int, steps: int) -> Array:
        """Return what each vehicle obeys in each of the physics steps from now on, (steps, n, 4)."""
        self._watch(now_ns)
        out = np.repeat(self._obeyed[None], steps, axis=0)
        last_ns = now_ns + (steps - 1) * step_ns
        for burst in self._flying:
            if burst.arrival_ns <= last_ns:
                first = max(-((now_ns - burst.arrival_ns) // step_ns), 0)  # first step at or after arrival
                self._receive(burst, out[first:], now_ns)
        self._flying = [burst for burst in self._flying if burst.arrival_ns > last_ns]
        self._obeyed = out[-1].copy()
        return out

    def _lost(self, rows: Rows) -> Mask:
        if self._params.loss == 0.0:
            return np.zeros(len(rows), dtype=np.bool_)
        return self._loss.random(len(self._next_ns))[rows] < self._params.loss

    def _coded(self, command: SwarmCommand) -> Array:
        """Return what the packets say, back in N and rad, (k, 4)."""
        if not self._params.quantised:
            thrust = np.clip(command.thrust, 0.0, self._scale.thrust_max)
            return np.column_stack([thrust, command.roll, command.pitch, command.yaw_rate])
        pitch, roll, yaw_rate, pwm = legacy_setpoints(command, self._scale).T
        degrees = np.stack([roll, pitch, yaw_rate]).astype(np.float32).astype(np.float64)
        thrust = np.where(pwm < PWM_MIN, 0.0, pwm) / PWM_MAX * self._scale.thrust_max
        return np.column_stack([thrust, *np.radians(degrees)])

    def _receive(self, burst: _Burst, rest: Array, now_ns: int) -> None:
        """Let vehicles obey packets in the rest of the tick's steps (k, n, 4)."""
        rows = burst.rows
        self._locked[rows] &= burst.values[:, 0] > 0.0
        self._heard_ns[rows] = max(burst.arrival_ns, now_ns)
        rest[:, rows] = burst.values
        if self._locked.any():
            rest[:, self._locked, 0] = 0.0

    def _watch(self, now_ns: int) -> None:
        silent_ns = now_ns - self._heard_ns
        self._obeyed[silent_ns > LEVEL_AFTER_NS, 1:] = 0.0
        cut = silent_ns > CUT_AFTER_NS
        self._obeyed[cut] = 0.0
        self._locked |= cut
