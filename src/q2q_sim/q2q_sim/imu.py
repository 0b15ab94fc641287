"""Read the inertial sensors of every vehicle: specific force and rate in the body frame, biased and noisy.

    f_body = R^T (a - g) + b_a + n_a,    g = (0, 0, -9.81)
    w_body = w + b_w + n_w

Biases are drawn once a flight, noise every tick. `a` is the acceleration of the physics step that ends at
the tick.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.parameters import check_bounds, tunable
from q2q_model.rotations import rotate_inverse
from q2q_model.signals import Array, SwarmImu, SwarmState
from q2q_model.vehicle import GRAVITY
from q2q_sim.streams import stream


@dataclass(frozen=True, slots=True)
class ImuParams:
    """Hold how well the sensors read; the defaults read perfectly."""

    acc_noise: float = tunable(0.0, "standard deviation of a reading", unit="m/s^2", low=0.0, high=50.0)
    acc_bias: float = tunable(0.0, "standard deviation of the bias", unit="m/s^2", low=0.0, high=10.0)
    gyro_noise: float = tunable(0.0, "standard deviation of a reading", unit="rad/s", low=0.0, high=10.0)
    gyro_bias: float = tunable(0.0, "standard deviation of the bias", unit="rad/s", low=0.0, high=10.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


class Imu:
    """Turn true motion into readings."""

    def __init__(self, params: ImuParams, vehicles: int, seed: int) -> None:
        self._params = params
        self._rng = stream(seed, "imu noise")
        scale = np.array([params.acc_bias, params.gyro_bias])[:, None, None]
        self._bias = scale * stream(seed, "imu bias").standard_normal((2, vehicles, 3))

    def read(self, truth: SwarmState, acc: Array) -> SwarmImu:
        """Return the readings at `truth` with acceleration `acc` [m/s^2], world, (n, 3); a call is a tick."""
        force = rotate_inverse(truth.quat, acc + np.array([0.0, 0.0, GRAVITY])) + self._bias[0]
        rate = truth.ang_vel_body + self._bias[1]
        params = self._params
        if params.acc_noise > 0.0 or params.gyro_noise > 0.0:
            noise = self._rng.standard_normal((2, *force.shape))
            force, rate = force + params.acc_noise * noise[0], rate + params.gyro_noise * noise[1]
        return SwarmImu(t=truth.t, names=truth.names, specific_force_body=force, ang_vel_body=rate)
