"""Fleet of vehicles that fly by their own firmware and communicate by CRTP.

    vehicles[i].handle(datagram, client) -> answers          at any time between ticks
    fly(drive)                                                one tick of 10 ms
    outgoing() -> (vehicle, client, datagram)                 datagrams due to clients after it

Vehicles that start in the air are held there until their first thrust, as by a hand.
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.crtp.vehicle import CrtpVehicle
from q2q_sim.firmware.controllers.columns import IDLE, MOTOR, SET_ACC
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.firmware_rows import FirmwareRows
from q2q_sim.firmware.firmware_tick import airframe_in, fly_tick, fresh_controllers
from q2q_sim.firmware.onboard_apps import OnboardApps
from q2q_sim.plant.swarm import Swarm


@dataclass(frozen=True, slots=True)
class Sent:
    """Datagram to a client."""

    vehicle: int
    """Row of the sending vehicle."""
    client: Hashable
    datagram: bytes


class Fleet:
    """Firmware of every vehicle of a swarm."""

    def __init__(self, swarm: Swarm, vehicle: Vehicle, build: Build, apps: OnboardApps | None = None) -> None:
        """Start the firmware of a swarm of vehicles of one type, with apps on board if given."""
        n, airframe = len(swarm.names), airframe_in(swarm, vehicle)
        self._swarm, self.apps = swarm, apps
        self._rows = fresh_controllers(airframe, n)
        rows = [FirmwareRows(swarm.state[i], self._rows.memory[i], self._rows.drift[i]) for i in range(n)]
        self.vehicles = tuple(
            CrtpVehicle(name, Firmware(airframe, replace(build, number=i), rows[i]))
            for i, name in enumerate(swarm.names)
        )
        self._changes = [-1] * n
        self._held = swarm.state[:, 2] > 0.0
        self._start = swarm.state.copy()

    def fly(self, drive: Array) -> None:
        """Advance by one tick of 10 ms.

        Args:
            drive: acceleration by wind [m/s^2], world, then the gain of each rotor, (n, 7).
        """
        for i, vehicle in enumerate(self.vehicles):
            self._rows.setpoints[i] = vehicle.firmware.tick()
        self._refresh_gains()
        fly_tick(self._swarm, self._rows, drive, self._each_step())
        self._hold()

    def outgoing(self) -> list[Sent]:
        """Return the datagrams due to clients now."""
        return [
            Sent(i, client, datagram)
            for i, vehicle in enumerate(self.vehicles)
            for client, datagram in vehicle.step()
        ]

    def _each_step(self) -> Callable[[], None] | None:
        """Return what the apps do in every step of this tick; None without apps."""
        if self.apps is None:
            return None
        wanted = self._rows.setpoints[:, :, SET_ACC + 2].copy()  # (n, 2)
        flying = [vehicle.firmware.supervisor.flying for vehicle in self.vehicles]
        return partial(self.apps.step, self._swarm.state, self._rows, wanted, flying)

    def _refresh_gains(self) -> None:
        changes = [vehicle.firmware.parameters.changes for vehicle in self.vehicles]
        if changes != self._changes:
            self._changes = changes
            gains = np.stack([vehicle.firmware.parameters.gains() for vehicle in self.vehicles])
            self._rows = self._rows._replace(gains=gains)

    def _hold(self) -> None:
        """Reset vehicles that are held in the air and have not been flown yet."""
        idle = self._rows.setpoints[:, 1, IDLE, None]
        self._held &= ~(self._rows.memory[:, MOTOR : MOTOR + 4] > idle).any(axis=1)
        self._swarm.state[self._held] = self._start[self._held]
