"""Crazyradio link from commands to vehicles: latency, loss, quantisation to degrees and PWM.

Each command is one RPYT packet per vehicle. It arrives `latency` (plus jitter) after the tick, or is lost.
On board, as in the Crazyflie firmware (crtp_commander_rpyt.c, commander.c):

- thrust is locked at zero until a packet with zero thrust has arrived;
- 0.5 s without a packet: level, no turning, thrust as it was;
- 2 s without a packet: motors cut, and locked again;
- thrust below 1000 PWM is set to 0, above 60000 to 60000.

Watchdogs are checked once per tick. A packet carries angles as 32-bit floats in degrees and thrust as integer
PWM; with `quantised` off it carries the exact command.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array, Mask, Rows, SwarmCommand
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.link.radio_kernel import deliver_packets, send_packets
from q2q_sim.random_streams import DrawnAhead, stream


@dataclass(frozen=True, slots=True)
class RadioParams:
    """Quality of the link; the defaults are transparent."""

    rate: float = tunable(100.0, "largest packet rate of each vehicle", unit="Hz", low=1.0, high=100.0)
    latency: float = tunable(0.0, "delay from sending a command to executing it", unit="s", low=0.0, high=0.5)
    jitter: float = tunable(0.0, "largest additional random latency", unit="s", low=0.0, high=0.009)
    loss: float = tunable(0.0, "fraction of packets lost", low=0.0, high=1.0)
    quantised: bool = tunable(default=False, description="round commands to integer PWM and 32-bit degrees")
    unlocked: bool = tunable(
        default=True, description="start with thrust unlocked, as by a packet of zero thrust"
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


class Radio:
    """Packets in the air and the present setpoint of each vehicle."""

    def __init__(self, params: RadioParams, at_start: Array, vehicle: Vehicle, seed: int) -> None:
        """Start with every vehicle level at a thrust [N] of `at_start` (n,)."""
        n = len(at_start)
        self._params = params
        self._scale = vehicle.rpyt_thrust_max, vehicle.full_pwm_thrust if params.quantised else 0.0
        self._loss = DrawnAhead(stream(seed, "radio loss").random, (n,))
        self._jitter = DrawnAhead(stream(seed, "radio jitter").random, (n,))
        self._gap_ns, self._latency_ns = round(1e9 / params.rate), round(1e9 * params.latency)
        self._next_ns = np.zeros(n, dtype=np.int64)
        self._flying = np.zeros((n, 2), dtype=np.int64), np.zeros((n, 4))  # packets in the air; they grow
        self._count = 0  # of them
        locked, applied = np.full(n, not params.unlocked), np.zeros((n, 4))
        applied[:, 0] = np.where(locked, 0.0, at_start)
        self._onboard = np.zeros(n, dtype=np.int64), locked, applied
        sent, nothing = (np.zeros(0, dtype=np.intp), self._next_ns, locked), (np.zeros((4, 0)), *self._scale)
        never = np.zeros(n), 0.0, np.zeros(n), 0.0
        # loads the kernel before the first tick
        send_packets((*self._flying, 0), nothing, sent, never, (0, 0, 0))

    @property
    def locked(self) -> Mask:
        """Return which vehicles keep their motors off until a packet without thrust, (n,)."""
        return self._onboard[1].copy()

    def send(self, now_ns: int, rows: Rows, values: Array, jammed: Mask) -> None:
        """Send the commands of the tick at now_ns, `command_values` (4, k); column k is for vehicle rows[k].

        Packets to `jammed` vehicles (n,) are lost in addition to random losses.
        """
        while self._count + len(rows) > len(self._flying[0]):
            when, what = self._flying
            self._flying = np.vstack([when, np.zeros_like(when)]), np.vstack([what, np.zeros_like(what)])
        flying, asked = (*self._flying, self._count), (values, *self._scale)
        sent, clock = (rows, self._next_ns, jammed), (now_ns, self._gap_ns, self._latency_ns)
        chance = self._loss.next(), self._params.loss, self._jitter.next(), self._params.jitter * 1e9
        self._count = send_packets(flying, asked, sent, chance, clock)

    def applied(self, now_ns: int, step_ns: int, steps: int) -> Array:
        """Return the setpoint of each vehicle in each physics step of the tick, (steps, n, 4)."""
        out = np.empty((steps, len(self._next_ns), 4))
        self._count = deliver_packets(self._flying, self._count, self._onboard, (now_ns, step_ns), out)
        return out


def command_values(command: SwarmCommand) -> Array:
    """Return thrust [N], roll, pitch [rad], yaw rate [rad/s] of the vehicles of a command, (4, k)."""
    values = np.concatenate((command.thrust, command.roll, command.pitch, command.yaw_rate))
    return values.reshape(4, len(command.names))
