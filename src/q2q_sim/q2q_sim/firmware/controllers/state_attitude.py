"""Attitude of a state row for the compiled controllers: body axes, and the firmware's Euler angles."""

import math

from q2q_model.compiled import compiled
from q2q_model.geometry.yaw import yaw_of
from q2q_model.signals.values import Array, Three
from q2q_sim.plant.body.quadcopter import tilt
from q2q_sim.plant.body.state_row import QW, QX, QY, QZ

Nine = tuple[float, float, float, float, float, float, float, float, float]

DEG = 180.0 / math.pi


@compiled
def axes(row: Array) -> Nine:
    """Return body x, y, z, world, of a state row (STATE_WIDTH,): the columns of R."""
    x, y, z, w = row[QX], row[QY], row[QZ], row[QW]
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y),
        2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x),
        2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


@compiled
def legacy_degrees(row: Array) -> Three:
    """Return roll, legacy pitch (nose up), yaw [deg] of a state row (STATE_WIDTH,)."""
    x, y, z, w = row[QX], row[QY], row[QZ], row[QW]
    roll, pitch, _ = tilt((x, y, z, w))
    return DEG * roll, -DEG * pitch, DEG * yaw_of(x, y, z, w)
