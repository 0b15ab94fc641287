"""Firmware apps on board of all vehicles of a room, with the broadcasts between them.

The app is that of q2q_control.onboard, compiled for this machine; here is what its glue in the real firmware
does. Every 2 ms, before the controller: packets that are due arrive, the app takes its step from the onboard
estimate, the accelerometer and the last thrust command, and the setpoint's acceleration becomes less by eta^.
Vehicles broadcast in turns, every 20 ms each.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_control.onboard.native_app import AppLibrary, NativeApp, StepInput
from q2q_model.geometry.rotations import UP, rotate
from q2q_model.signals.values import Array
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.firmware.controllers.columns import CONTROL, SET_ACC
from q2q_sim.firmware.firmware_tick import Controllers
from q2q_sim.plant.body.state_row import ACC, POS, QUAT, VEL
from q2q_sim.random_streams import stream

STEP_US = 2000
EVERY = 10
"""Steps between two broadcasts of a vehicle."""
THRUST = CONTROL + 3
"""Column of the thrust command [PWM]."""


@dataclass(frozen=True, slots=True)
class AppConditions:
    """Disturbances of the apps' inputs; the defaults are perfect."""

    broadcast_loss: float = tunable(0.0, "share of broadcasts that do not arrive", low=0.0, high=1.0)
    acc_noise: float = tunable(
        0.0, "standard deviation of the accelerometer, each 2 ms", unit="m/s^2", low=0.0, high=50.0
    )
    acc_bias: float = tunable(
        0.0, "standard deviation of the accelerometer's bias", unit="m/s^2", low=0.0, high=10.0
    )
    radio_range: float = tunable(100.0, "largest distance of a broadcast", unit="m", low=0.0, high=1e4)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


class _Broadcast(NamedTuple):
    """Packet in the air."""

    sender: int
    left_us: int
    packet: bytes


class OnboardApps:
    """Apps of all vehicles, and the packets in the air."""

    def __init__(self, libraries: Sequence[AppLibrary], conditions: AppConditions, seed: int) -> None:
        """Start the vehicles' apps, one of `libraries` on each.

        They take mass and thrust per PWM from their headers, as in the real firmware, whatever flies.
        """
        count = len(libraries)
        self.eta = np.zeros(count)
        """Subtracted from each setpoint's acceleration now [m/s^2]."""
        self._apps = [NativeApp(library) for library in libraries]
        self._acc_per_pwm = np.array([app.acc_per_pwm for app in self._apps])
        self._loss, self._noise = conditions.broadcast_loss, conditions.acc_noise
        self._range = conditions.radio_range
        self._losses, self._rng = stream(seed, "app broadcasts"), stream(seed, "app accelerometer")
        self._bias = conditions.acc_bias * self._rng.standard_normal(count)
        self._steps = 0
        self._sent: list[_Broadcast] = []

    def step(self, state: Array, rows: Controllers, wanted: Array, flying: Sequence[bool]) -> None:
        """Correct the setpoints before a step of the controllers.

        Args:
            state: the vehicles, (n, STATE_WIDTH).
            rows: their controllers; the acceleration of the setpoints is written.
            wanted: vertical acceleration of the setpoints without the apps [m/s^2], (n, 2).
            flying: whether each vehicle's motors run.
        """
        now_us = self._steps * STEP_US
        axis = rotate(state[:, QUAT], UP)
        estimate = np.hstack([state[:, POS], state[:, VEL]]) + rows.drift
        motion = np.hstack([estimate, axis])  # (n, 9)
        force = (
            state[:, ACC][:, 2] + GRAVITY + self._bias + self._noise * self._rng.standard_normal(len(axis))
        )
        thrust = self._acc_per_pwm * rows.memory[:, THRUST]
        self._deliver(motion[:, :3])
        for i, app in enumerate(self._apps):
            known = StepInput(now_us, motion[i], float(force[i]), float(thrust[i]), bool(flying[i]))
            self.eta[i] = app.step(known)
            packet = app.broadcast(i, motion[i]) if (self._steps - i) % EVERY == 0 else None
            if packet is not None:
                self._sent.append(_Broadcast(i, now_us, packet))
        rows.setpoints[:, :, SET_ACC + 2] = wanted - self.eta[:, None]
        self._steps += 1

    def _deliver(self, pos: Array) -> None:
        """Deliver what was broadcast in the step before, to receivers at `pos` (n, 3) within range."""
        for one in self._sent:
            near = np.linalg.norm(pos - pos[one.sender], axis=1) <= self._range
            for i in np.flatnonzero(near).tolist():
                if i != one.sender and self._losses.random() >= self._loss:
                    self._apps[i].hear(one.packet, one.left_us)
        self._sent.clear()
