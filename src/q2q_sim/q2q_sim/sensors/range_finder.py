"""Range finders of a vehicle: the distance along its body axes to floor, walls and ceiling of a room.

Source: firmware: modules/src/range.c, deck/drivers/src/multiranger.c, zranger2.c (VL53L1x). The room is a
box; other vehicles and the cone of the sensor are not seen. From p along the unit vector d, with the wall w
of each axis towards which d points:

    range = min over x, y, z of (w - p) / d
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.geometry.rotations import rotate
from q2q_model.signals.values import Array

AXES = np.array([[1, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 1, 0], [0, -1, 0], [0, 0, -1]], dtype=np.float64)
"""Front, back, up, left, right, down, body, (6, 3)."""
DOWN = 5
"""Row of the sensor that looks down."""
REACH = 4.0
"""Longest distance that a VL53L1x measures [m]: its data sheet."""
NOTHING_MM = 32766
"""Range in which nothing is: 32767 mm of the driver after it has passed through a float in m."""


@dataclass(frozen=True, slots=True)
class RoomBox:
    """Walls around a vehicle; by default a floor only."""

    half_x: float = np.inf
    """Distance of two walls from the origin along x [m]."""
    half_y: float = np.inf
    """[m]"""
    ceiling: float = np.inf
    """[m]"""

    def far(self, direction: Array) -> Array:
        """Return the coordinates of the walls that world directions (..., 3) point to [m], (..., 3)."""
        upper = np.array([self.half_x, self.half_y, self.ceiling])
        lower = np.array([-self.half_x, -self.half_y, 0.0])
        return np.where(direction > 0.0, upper, lower)


def ranges_mm(pos: Array, quat: Array, room: RoomBox) -> Array:
    """Return the ranges in the order of AXES [mm], (6,); NOTHING_MM where nothing is within REACH."""
    direction = rotate(quat, AXES)  # (6, 3)
    with np.errstate(all="ignore"):  # parallel to a wall
        along = (room.far(direction) - pos) / direction
    along[direction == 0.0] = np.inf
    distance = np.maximum(along.min(axis=-1), 0.0)  # 0 outside the room
    return np.where(distance <= REACH, 1e3 * distance, NOTHING_MM)
