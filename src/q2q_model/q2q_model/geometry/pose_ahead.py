"""Poses moved on by a delay at constant velocities, as they are sent to vehicles.

The firmware takes a pose for current however late it is, so at speed v a pose as captured is wrong by v d.

    p + d v,   q exp(d w)

| symbol | name | meaning [unit] |
|---|---|---|
| p v | pos vel | position and velocity at capture, world [m], [m/s] |
| q w | quat ang_vel_body | attitude, body to world, and body rate at capture [rad/s] |
| d | delay | from capture to the onboard estimate [s] |
"""

from typing import Protocol

from q2q_model.geometry.rotations import integrate_quat
from q2q_model.signals.values import Array


class MeasuredMotion(Protocol):
    """Motion of vehicles at capture, as in q2q_model.signals.values.SwarmState."""

    @property
    def pos(self) -> Array:
        """Position [m], world, (..., 3)."""

    @property
    def vel(self) -> Array:
        """Velocity [m/s], world, (..., 3)."""

    @property
    def quat(self) -> Array:
        """Attitude, body to world, (..., 4)."""

    @property
    def ang_vel_body(self) -> Array:
        """Body rate [rad/s], (..., 3)."""


def extrapolate_pose(motion: MeasuredMotion, delay: float) -> tuple[Array, Array]:
    """Return positions [m], (..., 3), and attitudes, (..., 4), after `delay` [s] at constant velocities."""
    return motion.pos + delay * motion.vel, integrate_quat(motion.quat, motion.ang_vel_body, delay)
