"""Setpoint of a vehicle's controller: on each axis an absolute value, a velocity, or nothing.

Source: firmware: modules/interface/stabilizer_types.h (setpoint_t, stab_mode_t).
"""

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from q2q_model.signals.values import Four, Three
from q2q_sim.firmware.commander.polynomial import Goal

ZERO: Three = (0.0, 0.0, 0.0)


class Mode(IntEnum):
    """Control modes of an axis."""

    DISABLE = 0
    ABS = 1
    VELOCITY = 2


@dataclass(frozen=True, slots=True)
class Setpoint:
    """One setpoint; the default controls nothing and stops the motors."""

    x: Mode = Mode.DISABLE
    y: Mode = Mode.DISABLE
    z: Mode = Mode.DISABLE
    roll: Mode = Mode.DISABLE
    pitch: Mode = Mode.DISABLE
    yaw: Mode = Mode.DISABLE
    quat: Mode = Mode.DISABLE
    """The yaw of `attitude_quat` is the setpoint (full state)."""
    pos: Three = ZERO
    """[m], world."""
    vel: Three = ZERO
    """[m/s], world; body where velocity_body."""
    acc: Three = ZERO
    """[m/s^2], world."""
    attitude_deg: Three = ZERO
    """Roll, legacy pitch, yaw [deg]."""
    rate_deg: Three = ZERO
    """Rates about body x, y, z [deg/s]; for rate control of pitch (RPYT, manual) the legacy pitch rate."""
    attitude_quat: Four = (0.0, 0.0, 0.0, 1.0)
    """x y z w, body to world."""
    thrust_pwm: float = 0.0
    """Of each motor, if z is not controlled [PWM]."""
    velocity_body: bool = False
    """vel x, y are forward and left."""


STOP = Setpoint()
"""Motors off."""


def setpoint_of(goal: Goal) -> Setpoint:
    """Return the full-state setpoint of a goal of the high-level commander."""
    px, py, pz = goal.pos.tolist()
    vx, vy, vz = goal.vel.tolist()
    ax, ay, az = goal.acc.tolist()
    p, q, r = np.degrees(goal.ang_vel_body).tolist()
    return Setpoint(
        x=Mode.ABS,
        y=Mode.ABS,
        z=Mode.ABS,
        yaw=Mode.ABS,
        pos=(px, py, pz),
        vel=(vx, vy, vz),
        acc=(ax, ay, az),
        attitude_deg=(0.0, 0.0, math.degrees(goal.yaw)),
        rate_deg=(p, q, r),
    )
