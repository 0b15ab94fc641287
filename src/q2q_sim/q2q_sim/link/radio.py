"""Carry commands to the vehicles as the Crazyradio does: late, at times lost, in degrees and PWM.

Each command of a tick is one RPYT packet a vehicle. It arrives `latency` (plus jitter) after the tick, or is
lost. On board, as in the Crazyflie firmware (crtp_commander_rpyt.c, commander.c):

- thrust stays locked at zero until one packet with zero thrust has come;
- 0.5 s without a packet: level, no turning, thrust as it was;
- 2 s without a packet: motors cut, and locked again;
- thrust below 1000 PWM is none, above 60000 is 60000.

Watchdogs are looked at once a tick. A packet carries angles as 32-bit floats in degrees and thrust as a whole
number of PWM; with `quantised` off it carries what was asked. Apart from q2q_control.radio.rpyt_scale this
is the only place with degrees and PWM.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.radio.rpyt_scale import LegacyScale, legacy_setpoints
from q2q_model.signals.values import Array, SwarmCommand
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.link.packets import deliver, put
from q2q_sim.plant.random_streams import stream
from q2q_sim.sensors.episodes import Mask

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


class Radio:
    """Hold the packets on their way, and what each vehicle obeys."""

    def __init__(self, params: RadioParams, at_start: Array, vehicle: Vehicle, seed: int) -> None:
        """Start with every vehicle obeying a thrust [N] of `at_start` (n,), level."""
        n = len(at_start)
        self._params = params
        self._scale, self._rpyt_thrust_max = LegacyScale(vehicle.full_pwm_thrust), vehicle.rpyt_thrust_max
        self._loss, self._jitter = stream(seed, "radio loss"), stream(seed, "radio jitter")
        self._gap_ns, self._latency_ns = round(1e9 / params.rate), round(1e9 * params.latency)
        self._next_ns = np.zeros(n, dtype=np.int64)
        self._in_time = np.zeros(n, dtype=np.int64)
        self._flying = np.zeros((n, 2), dtype=np.int64), np.zeros((n, 4))  # packets in the air; they grow
        self._count = 0  # of them
        locked, obeyed = np.full(n, not params.unlocked), np.zeros((n, 4))
        obeyed[:, 0] = np.where(locked, 0.0, at_start)
        self._onboard = np.zeros(n, dtype=np.int64), locked, obeyed
        sent = np.zeros(0, dtype=np.intp), self._next_ns, locked, self._in_time
        put(
            self._flying, 0, (np.zeros((4, 0)), self._rpyt_thrust_max), sent, (0, 0, 0)
        )  # loads it before the first tick

    def send(self, now_ns: int, rows: Rows, command: SwarmCommand, jammed: Mask) -> None:
        """Send the command of the tick at now_ns; row k of it is for vehicle rows[k].

        Packets to vehicles that are `jammed` (n,) are lost besides those that are lost anyway.
        """
        asked = self._coded(command), self._rpyt_thrust_max
        while self._count + len(rows) > len(self._flying[0]):
            when, what = self._flying
            self._flying = np.vstack([when, np.zeros_like(when)]), np.vstack([what, np.zeros_like(what)])
        sent = rows, self._next_ns, jammed | self._lost(), self._late_ns()
        self._count = put(self._flying, self._count, asked, sent, (now_ns, self._gap_ns, self._latency_ns))

    def obeyed(self, now_ns: int, step_ns: int, steps: int) -> Array:
        """Return what each vehicle obeys in each of the physics steps from now on, (steps, n, 4)."""
        out = np.empty((steps, len(self._next_ns), 4))
        self._count = deliver(self._flying, self._count, self._onboard, (now_ns, step_ns), out)
        return out

    def _lost(self) -> Mask | bool:
        """Return whose packet of this tick is lost, (n,)."""
        return self._params.loss > 0.0 and self._loss.random(len(self._next_ns)) < self._params.loss

    def _late_ns(self) -> NDArray[np.int64]:
        """Return how late the packets of this tick come beside the latency [ns], (n,)."""
        if self._params.jitter == 0.0:
            return self._in_time
        late = self._jitter.random(len(self._next_ns)) * (self._params.jitter * 1e9)
        return np.rint(late).astype(np.int64)

    def _coded(self, command: SwarmCommand) -> Array:
        """Return what the packets say, back in N and rad: thrust, roll, pitch, yaw rate, (4, k)."""
        if not self._params.quantised:
            values = np.concatenate((command.thrust, command.roll, command.pitch, command.yaw_rate))
            return values.reshape(4, -1)
        pitch, roll, yaw_rate, pwm = legacy_setpoints(command, self._scale).T
        degrees = np.stack([roll, pitch, yaw_rate]).astype(np.float32).astype(np.float64)
        thrust = self._scale.thrust_of(np.where(pwm < PWM_MIN, 0.0, pwm))
        return np.stack([thrust, *np.radians(degrees)])
