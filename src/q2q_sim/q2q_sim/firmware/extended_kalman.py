"""Extended Kalman filter of the firmware: position, velocity and attitude from IMU and external poses.

Source: firmware: modules/src/kalman_core/kalman_core.c, mm_pose.c, estimator/estimator_kalman.c, after
Mueller, Hamer, D'Andrea, ICRA 2015, and Mueller, Hehn, D'Andrea, J. Guidance 40, 2016. (`estimator` is its
part that emulated vehicles fly with: they know attitude and acceleration.) Every 10 ms, by Euler's method:

    x += R (p dt + f dt^2/2) - g dt^2/2,   p += dt (f - w x p - R^T g),   q <- q exp(w dt)
    P  = A P A^T;  every h = 1 ms:  P += diag((s_f h^2)^2, (s_f h)^2, (s_w h)^2)
    K  = P e_i / (P_ii + r^2),  s += K (z - s_i)   for x, y, z, then for the turn from q to the pose's

and the attitude error d is moved into q. Its weaknesses are kept: in flight only the z of the accelerometer
counts, so that drag is taken for a tilt; poses count as current however late they are; none is gated; the
accelerometer's and gyroscope's biases are not estimated; variances stay above 1e-6. GENERAL_PURPOSE is
the build with CONFIG_ESTIMATOR_KALMAN_GENERAL_PURPOSE. An estimate beyond 100 m or 10 m/s starts again.

| symbol | name | meaning [unit] |
|---|---|---|
| x | pos | position, world [m], (n, 3) |
| p | vel_body | velocity, body [m/s], (n, 3) |
| q | quat | attitude, body to world, (n, 4) |
| d | | attitude error, body [rad]; 0 between ticks |
| P | cov | covariance of x, p, d, (n, 9, 9) |
| f | specific_force_body | accelerometer, mean over the tick [m/s^2], (n, 3) |
| w | ang_vel_body | gyroscope, mean over the tick [rad/s], (n, 3) |
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.geometry.rotations import (
    UP,
    integrate_quat,
    matrix_from_quat,
    normalised,
    quat_between,
    quat_from_vector,
    quat_multiply,
)
from q2q_model.signals.values import Array, Mask
from q2q_model.tunable import check_bounds, tunable
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.firmware.estimator import COVARIANCE_MAX, DT, NOISE_STEPS, START_STD, START_VEL_STD, VARIANCE_MIN

X, P, D = slice(0, 3), slice(3, 6), slice(6, 9)
"""Rows of x, p and d."""
START_ATTITUDE_STD = 0.01
"""stdDevInitialAttitude_rollpitch, _yaw [rad], kalman_core_params_defaults.h."""
REVERSION = 0.001
"""Share of the initial attitude in each tick on the ground (attitudeReversion)."""
SMALLEST_TURN = 1e-4
"""Attitude error below which the attitude is not corrected [rad]."""
LARGEST_TURN = 10.0
"""Attitude error from which it is not corrected either [rad]."""
POS_MAX, VEL_MAX = 100.0, 10.0
"""Bounds of an estimate [m], [m/s], kalman_supervisor.c."""


@dataclass(frozen=True, slots=True)
class ExtendedKalmanParams:
    """Parameters of the filter; the defaults are the firmware's."""

    acc_noise_xy: float = tunable(0.5, "kalman.pNAcc_xy", unit="m/s^2", low=0.0, high=100.0)
    acc_noise_z: float = tunable(1.0, "kalman.pNAcc_z", unit="m/s^2", low=0.0, high=100.0)
    gyro_noise: float = tunable(0.1, "kalman.mNGyro_rollpitch, _yaw", unit="rad/s", low=0.0, high=10.0)
    pos_std: float = tunable(0.01, "locSrv.extPosStdDev", unit="m", low=1e-6, high=10.0)
    quat_std: float = tunable(4.5e-3, "locSrv.extQuatStdDev", unit="rad", low=1e-6, high=10.0)
    all_axes: bool = tunable(
        default=False,
        description="all axes of the accelerometer count in flight",
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)


GENERAL_PURPOSE = ExtendedKalmanParams(acc_noise_z=0.5, all_axes=True)
"""Defaults of the build with CONFIG_ESTIMATOR_KALMAN_GENERAL_PURPOSE (kalmanCoreDefaultParams)."""


class ExtendedKalman:
    """Estimates of n vehicles that do not know of each other."""

    def __init__(self, params: ExtendedKalmanParams, initial_quat: Array) -> None:
        """Start at the origin with attitudes `initial_quat`, (n, 4)."""
        self._params = params
        count = len(initial_quat)
        self._initial_quat = initial_quat
        self._noise = process_noise(params)
        self.pos, self.vel_body = np.zeros((count, 3)), np.zeros((count, 3))
        self.quat, self.cov = initial_quat.copy(), np.zeros((count, 9, 9))
        self.resets = np.zeros(count, dtype=np.int64)
        """Number of restarts after an estimate beyond the bounds, (n,)."""
        self._start(np.ones(count, dtype=np.bool_))

    def predict(self, specific_force_body: Array, ang_vel_body: Array, *, flying: bool) -> None:
        """Advance by one tick, with specific force [m/s^2] and angular velocity [rad/s], body, (n, 3)."""
        params, w = self._params, ang_vel_body
        only_thrust = flying and not params.all_axes
        f = specific_force_body * UP if only_thrust else specific_force_body
        R, p = matrix_from_quat(self.quat), self.vel_body
        A = kalman_transition(R, p, w)
        self.cov = A @ self.cov @ A.transpose(0, 2, 1)
        step = DT * p + 0.5 * DT * DT * f
        self.pos = self.pos + np.einsum("nij,nj->ni", R, step) - 0.5 * DT * DT * GRAVITY * UP
        self.vel_body = p + DT * (f - np.cross(w, p) - GRAVITY * R[:, 2])
        self.quat = integrate_quat(self.quat, w, DT)
        if not flying or params.all_axes:
            self.quat = normalised((1.0 - REVERSION) * self.quat + REVERSION * self._initial_quat)
        self.cov += self._noise
        self._keep_bounds()

    def correct(self, given: Mask, pos: Array, quat: Array) -> None:
        """Fuse poses, (n, 3) and (n, 4), of the vehicles `given`, (n,)."""
        error = np.zeros((len(given), 9))  # x and p as their corrections, d
        for i in range(3):
            self._fuse(i, np.where(given, pos[:, i] - self.pos[:, i] - error[:, i], 0.0), given, error)
        between = quat_between(self.quat, quat)
        turn = 2.0 * between[:, :3] / between[:, 3:]
        for i in range(3):
            self._fuse(6 + i, np.where(given, turn[:, i], 0.0), given, error)
        self.pos, self.vel_body = self.pos + error[:, X], self.vel_body + error[:, P]
        self._turn(error[:, D])
        self._keep_bounds()
        self._start(self._is_out_of_bounds())

    def _fuse(self, row: int, surprise: Array, given: Mask, error: Array) -> None:
        """Correct the state by its element `row`, in Joseph's form."""
        std = self._params.pos_std if row < 3 else self._params.quat_std
        P = self.cov
        K = P[:, :, row] / (P[:, row, row] + std**2)[:, None] * given[:, None]
        error += K * surprise[:, None]
        P = P - K[:, :, None] * P[:, None, row]
        P = P - P[:, :, row, None] * K[:, None]
        self.cov = P + std**2 * K[:, :, None] * K[:, None]
        self._keep_bounds()

    def _turn(self, error: Array) -> None:
        """Move attitude errors (n, 3) into the attitudes, and turn their covariances."""
        size = np.abs(error).max(axis=1)
        large = np.asarray((size > SMALLEST_TURN) & (size < LARGEST_TURN))
        turned = np.where(large[:, None], error, 0.0)
        self.quat = normalised(quat_multiply(self.quat, quat_from_vector(turned)))
        A = np.tile(np.eye(9), (len(error), 1, 1))
        A[:, D, D] = small_rotation(0.5 * turned)
        self.cov = A @ self.cov @ A.transpose(0, 2, 1)

    def _keep_bounds(self) -> None:
        self.cov = np.minimum(0.5 * (self.cov + self.cov.transpose(0, 2, 1)), COVARIANCE_MAX)
        variances = np.einsum("nii->ni", self.cov)
        np.maximum(variances, VARIANCE_MIN, out=variances)

    def _is_out_of_bounds(self) -> Mask:
        far = (np.abs(self.pos) > POS_MAX).any(axis=1) | (np.abs(self.vel_body) > VEL_MAX).any(axis=1)
        self.resets += far
        return np.asarray(far)

    def _start(self, rows: Mask) -> None:
        """Start the estimates of some vehicles at the origin, at rest."""
        self.pos[rows], self.vel_body[rows], self.quat[rows] = 0.0, 0.0, self._initial_quat[rows]
        std = np.concatenate([START_STD, np.full(3, START_VEL_STD), np.full(3, START_ATTITUDE_STD)])
        self.cov[rows] = np.diag(std**2)


def process_noise(params: ExtendedKalmanParams) -> Array:
    """Return what a tick adds to the covariance, (9, 9)."""
    h = DT / NOISE_STEPS
    acc = np.array([params.acc_noise_xy, params.acc_noise_xy, params.acc_noise_z])
    std = np.concatenate([acc * h * h, acc * h, np.full(3, params.gyro_noise * h)])
    return np.diag(NOISE_STEPS * std**2)


def kalman_transition(R: Array, p: Array, w: Array) -> Array:
    """Return A of a tick, (n, 9, 9), at attitude R (n, 3, 3), velocity p and rate w, body, (n, 3) each."""
    A = np.tile(np.eye(9), (len(R), 1, 1))
    A[:, X, P] = DT * R
    A[:, X, D] = -DT * R @ cross_matrix(p)
    A[:, P, P] -= DT * cross_matrix(w)
    A[:, P, D] = -DT * GRAVITY * cross_matrix(R[:, 2])
    A[:, D, D] = small_rotation(0.5 * DT * w)
    return A


def small_rotation(half: Array) -> Array:
    """Return exp(-[d]x) to the second order for d (n, 3), as the firmware has it, (n, 3, 3)."""
    outer = half[:, :, None] * half[:, None]
    squared = np.einsum("ni,ni->n", half, half)[:, None, None]
    return np.asarray(np.eye(3) - cross_matrix(half) + 0.5 * (outer - squared * np.eye(3)))


def cross_matrix(vector: Array) -> Array:
    """Return the matrix [a]x of the cross product, a x b = [a]x b, (n, 3) -> (n, 3, 3)."""
    x, y, z = vector.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
