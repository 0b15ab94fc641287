"""Poses sent to vehicles: those of the motion after the delay, in closed form."""

from dataclasses import dataclass

import numpy as np
import pytest

from q2q_model.geometry.pose_ahead import extrapolate_pose
from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import Array

LEVEL = np.zeros(2)
VEL = np.array([[1.0, -2.0, 0.5], [0.0, 0.0, -1.5]])
YAW_RATE = np.array([3.0, -1.0])
"""[rad/s], of level vehicles: of the body as of the world."""


@dataclass(frozen=True)
class _Motion:
    pos: Array
    vel: Array
    quat: Array
    ang_vel_body: Array


def motion_at(t: float) -> _Motion:
    """Return two vehicles that move straight and turn about z, both uniformly, at time t [s]."""
    rate = np.stack([LEVEL, LEVEL, YAW_RATE], axis=1)
    return _Motion(t * VEL, VEL, quat_from_euler(LEVEL, LEVEL, YAW_RATE * t), rate)


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.1])
def test_a_sent_pose_is_that_of_uniform_motion_after_the_delay(delay: float) -> None:
    later = motion_at(0.3 + delay)
    pos, quat = extrapolate_pose(motion_at(0.3), delay)
    np.testing.assert_allclose(pos, later.pos, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(quat, later.quat, rtol=0.0, atol=1e-15)


def test_a_tilted_body_turns_about_its_own_axis() -> None:
    """A quarter roll (h 0 0 h) times a quarter turn about the body's z (0 0 h h), h = sqrt(1/2)."""
    quarter = 0.5 * np.pi
    one = _Motion(
        np.zeros(3), np.zeros(3), quat_from_euler(quarter, 0.0, 0.0), np.array([0.0, 0.0, quarter / 0.1])
    )
    np.testing.assert_allclose(extrapolate_pose(one, 0.1)[1], [0.5, -0.5, 0.5, 0.5], rtol=0.0, atol=1e-15)
