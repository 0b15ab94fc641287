"""Inertial sensors of every vehicle: biased and noisy specific force and angular rate, body frame.

    f_body = R^T (a - g) + b_a + n_a,    g = (0, 0, -9.81)
    w_body = w + b_w + n_w

Biases are drawn once per flight, noise every tick. `a` is the acceleration during the physics step that ends
at the tick.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, SwarmImu, SwarmState
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.random_streams import stream


@dataclass(frozen=True, slots=True)
class ImuParams:
    """Noise of the sensors; the defaults are perfect."""

    acc_noise: float = tunable(
        0.0, "standard deviation of an accelerometer reading", unit="m/s^2", low=0.0, high=50.0
    )
    acc_bias: float = tunable(
        0.0, "standard deviation of the accelerometer bias", unit="m/s^2", low=0.0, high=10.0
    )
    gyro_noise: float = tunable(
        0.0, "standard deviation of a gyroscope reading", unit="rad/s", low=0.0, high=10.0
    )
    gyro_bias: float = tunable(
        0.0, "standard deviation of the gyroscope bias", unit="rad/s", low=0.0, high=10.0
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


@compiled
def readings(motion: tuple[Array, Array, Array], bias: Array, out: tuple[Array, Array]) -> None:
    """Write specific force [m/s^2] and rate [rad/s], body, (n, 3) each, to `out`.

    `motion` is quat, ang_vel_body and acc [m/s^2], world; `bias` (2, n, 3) that of force and rate.
    """
    quat, ang_vel, acc = motion
    force, rate = out
    for i in range(quat.shape[0]):
        x, y, z, w = -quat[i, 0], -quat[i, 1], -quat[i, 2], quat[i, 3]
        ax, ay, az = acc[i, 0], acc[i, 1], acc[i, 2] + GRAVITY
        tx, ty, tz = 2.0 * (y * az - z * ay), 2.0 * (z * ax - x * az), 2.0 * (x * ay - y * ax)
        force[i, 0] = ax + w * tx + (y * tz - z * ty) + bias[0, i, 0]
        force[i, 1] = ay + w * ty + (z * tx - x * tz) + bias[0, i, 1]
        force[i, 2] = az + w * tz + (x * ty - y * tx) + bias[0, i, 2]
        for k in range(3):
            rate[i, k] = ang_vel[i, k] + bias[1, i, k]


class Imu:
    """Sensor model from true motion to readings."""

    def __init__(self, params: ImuParams, vehicles: int, seed: int) -> None:
        self._params = params
        self._rng = stream(seed, "imu noise")
        scale = np.array([params.acc_bias, params.gyro_bias])[:, None, None]
        self._bias = scale * stream(seed, "imu bias").standard_normal((2, vehicles, 3))

    def read(self, truth: SwarmState, acc: Array) -> SwarmImu:
        """Return readings at `truth` with acceleration `acc` [m/s^2], world, (n, 3); call once per tick."""
        force, rate = np.empty_like(self._bias[0]), np.empty_like(self._bias[0])
        readings((truth.quat, truth.ang_vel_body, acc), self._bias, (force, rate))
        params = self._params
        if params.acc_noise > 0.0 or params.gyro_noise > 0.0:
            noise = self._rng.standard_normal((2, *force.shape))
            force, rate = force + params.acc_noise * noise[0], rate + params.gyro_noise * noise[1]
        return SwarmImu(t=truth.t, names=truth.names, specific_force_body=force, ang_vel_body=rate)
