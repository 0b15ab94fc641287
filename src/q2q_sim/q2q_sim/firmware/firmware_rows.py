"""What the firmware of one vehicle knows of its motion, from its rows of the swarm's arrays."""

from dataclasses import dataclass

import numpy as np

from q2q_model.geometry.rotations import rotate_inverse
from q2q_model.signals.values import Array, Three
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.firmware.controllers.state_attitude import DEG, legacy_degrees
from q2q_sim.firmware.firmware_build import LOOKS_AROUND, LOOKS_DOWN, Build
from q2q_sim.plant.body.state_row import ACC, POS, QUAT, RATE, VEL
from q2q_sim.sensors.range_finder import DOWN, ranges_mm


@dataclass(frozen=True, slots=True)
class FirmwareRows:
    """One vehicle's rows of the swarm's arrays, as views."""

    state: Array
    """state_row, (STATE_WIDTH,)."""
    memory: Array
    """columns, (MEMORY_WIDTH,)."""
    drift: Array
    """(6,)"""

    @property
    def pos(self) -> Array:
        """Return the estimated position [m], world, (3,)."""
        return np.asarray(self.state[POS] + self.drift[:3])

    @property
    def vel(self) -> Array:
        """Return the estimated velocity [m/s], world, (3,)."""
        return np.asarray(self.state[VEL] + self.drift[3:])

    @property
    def attitude_deg(self) -> Three:
        """Return roll, legacy pitch, yaw [deg]."""
        angles: Three = legacy_degrees(self.state)
        return angles

    @property
    def specific_force_g(self) -> Array:
        """Return the accelerometer reading [g], body, (3,)."""
        up = np.array([0.0, 0.0, GRAVITY])
        return np.asarray(rotate_inverse(self.state[QUAT], self.state[ACC] + up) / GRAVITY)

    @property
    def rates_deg(self) -> Array:
        """Return the gyroscope reading [deg/s], body, (3,)."""
        return np.asarray(DEG * self.state[RATE])

    def ranges_mm(self, build: Build) -> Array:
        """Return the ranges to front, back, up, left, right, down [mm], (6,); 0 without a deck."""
        around, below = LOOKS_AROUND in build.decks, not LOOKS_DOWN.isdisjoint(build.decks)
        looks = np.where(np.arange(DOWN + 1) == DOWN, below, around)
        return looks * ranges_mm(self.state[POS], self.state[QUAT], build.room)
