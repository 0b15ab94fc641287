"""Commands in the units of the Crazyflie's RPYT setpoint, as in `cmd_vel_legacy`.

| field | meaning [unit] |
|---|---|
| linear.x | pitch [deg] |
| linear.y | roll [deg] |
| angular.z | yaw rate [deg/s] |
| linear.z | thrust [PWM 0..60000] |

Signs are those of a command; Crazyswarm2's servers take others (q2q_control.crazyswarm.message_conversion).
Thrust is linear in PWM, by the table of vehicle and firmware (q2q_model.vehicle.thrust_map).
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array, SwarmCommand
from q2q_model.vehicle.thrust_map import PWM_FULL, RPYT_PWM_MAX


@dataclass(frozen=True, slots=True)
class RpytScale:
    """Scale between newtons and PWM."""

    full_pwm_thrust: float
    """Collective thrust with every motor at PWM_FULL [N]."""

    def pwm_of(self, thrust: Array) -> Array:
        """Return the PWM of collective thrusts (...,) [N], neither rounded nor clipped."""
        return np.asarray(thrust / self.full_pwm_thrust * PWM_FULL)

    def rpyt_pwm_of(self, thrust: Array) -> Array:
        """Return the PWM of collective thrusts (...,) [N] as RPYT setpoints carry them."""
        return np.clip(np.round(self.pwm_of(thrust)), 0, RPYT_PWM_MAX)


def rpyt_rows(command: SwarmCommand, scale: RpytScale) -> Array:
    """Return pitch [deg], roll [deg], yaw rate [deg/s], thrust [PWM] of every vehicle, (n, 4)."""
    angles = np.degrees([command.pitch, command.roll, command.yaw_rate])  # (3, n)
    return np.column_stack([*angles, scale.rpyt_pwm_of(command.thrust)])
