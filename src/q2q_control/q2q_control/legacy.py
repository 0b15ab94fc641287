"""Say a command in the units of the Crazyflie's RPYT setpoint, as `cmd_vel_legacy` carries it.

| field | meaning [unit] |
|---|---|
| linear.x | pitch [deg] |
| linear.y | roll [deg] |
| angular.z | yaw rate [deg/s] |
| linear.z | thrust [PWM 0..60000] |

Thrust is mapped linearly: full PWM is the vehicle's largest thrust. This file and q2q_sim.radio are the
only places with degrees and PWM.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals import Array, SwarmCommand

PWM_MAX = 60000
"""Largest thrust that the Crazyflie's commander accepts [PWM]."""


@dataclass(frozen=True, slots=True)
class LegacyScale:
    """Hold what turns newtons into PWM."""

    thrust_max: float
    """Thrust at PWM_MAX [N]."""


def legacy_setpoints(command: SwarmCommand, scale: LegacyScale) -> Array:
    """Return pitch [deg], roll [deg], yaw rate [deg/s], thrust [PWM] of every vehicle, (n, 4)."""
    pwm = np.clip(np.round(command.thrust / scale.thrust_max * PWM_MAX), 0, PWM_MAX)
    angles = np.degrees([command.pitch, command.roll, command.yaw_rate])  # (3, n)
    return np.column_stack([*angles, pwm])
