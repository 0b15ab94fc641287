"""Test bench for one vehicle's firmware: it receives packets and drives motors, but does not move."""

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.crtp.vehicle import CrtpVehicle
from q2q_sim.firmware.controllers.columns import frame_row, fresh_memory
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.firmware_rows import FirmwareRows
from q2q_sim.firmware.firmware_tick import STEPS, Controllers, control_motors
from q2q_sim.firmware.motors.airframe import airframe_of
from q2q_sim.plant.body.state_row import ACC, state_at_rest

UP = np.array([0.0, 0.0, GRAVITY])


class Bench:
    """Firmware of a vehicle that is clamped, level."""

    def __init__(self, start: Array, *, auto_arming: bool) -> None:
        """Place the vehicle at `start`: x, y, z [m], yaw [rad], (4,)."""
        airframe = airframe_of(CRAZYFLIE_2_0)
        self._state = state_at_rest(start[None], 0.0)[0]
        self._memory, self._frame = fresh_memory(1), frame_row(airframe)[None]
        self._drift = np.zeros((1, 6))
        rows = FirmwareRows(self._state, self._memory[0], self._drift[0])
        self.firmware = Firmware(airframe, Build(auto_arming=auto_arming), rows)
        self._drift[:] = 0.0  # it knows where it is
        self._vehicle = CrtpVehicle("bench", self.firmware)

    def handle(self, datagram: bytes) -> list[bytes]:
        """Return the answers to a datagram."""
        return self._vehicle.handle(datagram)

    def feel(self, specific_force_g: Array) -> None:
        """Set the accelerometer reading [g], body, (3,)."""
        self._state[ACC] = GRAVITY * specific_force_g - UP

    def tick(self) -> None:
        """Advance by 10 ms."""
        setpoints, gains = self.firmware.tick()[None], self.firmware.parameters.gains()[None]
        controllers = Controllers(setpoints, gains, self._memory, self._frame, self._drift)
        forces = np.empty(4)
        for k in range(STEPS):
            control_motors(self._state, controllers, 0, k, forces)
