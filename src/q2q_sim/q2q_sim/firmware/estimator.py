"""Onboard estimate of position and velocity from external positions, with its covariance.

Source: firmware: modules/src/kalman_core/kalman_core.c, mm_position.c (state x, v; scalar updates on x), axis
by axis, 100 times per second. The accelerometer is assumed exact, so the state is the *error* of the
estimate e = x^ - x, which drifts with its own velocity:

    e' = e_v,  e_v' = 0,   P' = F P F',  F = [1 dt; 0 1]                       every 10 ms
    P += diag((q h^2)^2, (q h)^2),  1e-6 <= P_kk,  P <= 100                     every h = 1 ms
    K = P h_x / (P_11 + r^2),  e += K (z - x^),  h_x = (1, 0),  bounds again

A flow deck measures velocity along the ground and height, both exact here (mm_flow.c, mm_tof.c; standard
deviations of the stock drivers): the horizontal error keeps its initial value.

The attitude is assumed known, from gyroscope and accelerometer; the quaternion of an external pose is logged,
not fused.

| symbol | name | meaning [unit] |
|---|---|---|
| q | kalman.pNAcc_xy, _z | acceleration noise [m/s^2] |
| r | locSrv.extPosStdDev | [m] |
| z | measured | external position [m], world |
"""

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.plant.body.state_row import POS

DT = 0.01
"""[s]"""
STEP = np.array([[1.0, DT], [0.0, 1.0]])
"""F."""
NOISE_STEPS = 10
"""Number of process-noise updates in each DT."""
VARIANCE_MIN, COVARIANCE_MAX = 1e-6, 100.0
"""MIN_COVARIANCE (of the diagonal), MAX_COVARIANCE, kalman_core.c [m^2], [m^2/s^2]."""
START_STD = np.array([100.0, 100.0, 1.0])
"""stdDevInitialPosition_xy, _z [m], kalman_core_params_defaults.h."""
START_VEL_STD = 0.01
"""stdDevInitialVelocity [m/s], the same."""

PIXELS = 35.0 * 0.01 / 0.71674
"""Flow in 10 ms per angular velocity of the ground [s]: 35 pixels over 0.71674 rad."""
FLOW_STD = 0.2 / PIXELS
"""Of the velocity by flow, per metre of height [1/s]: 0.2 pixels."""
FLOW_HEIGHT_MIN = 0.1
"""Smallest height that scales the flow [m]."""
RANGE_STD = 2.5e-3
"""Of the height below 2 m: expStdA of the ranger [m]."""


class Estimator:
    """Error of the estimate and its covariance, one row for each axis."""

    def __init__(self, drift: Array) -> None:
        """Take the row of the estimate's error for the controllers: position, velocity, world, (6,)."""
        self.drift = drift
        self._cov = np.zeros((3, 2, 2))
        self._variances = np.einsum("kii->ki", self._cov)  # a view: the diagonals, (3, 2)
        self.forget(np.zeros(3), np.zeros(3))

    @property
    def variance(self) -> Array:
        """Return the variances of position [m^2] and velocity [m^2/s^2], (6,)."""
        return np.asarray(self._variances.T.ravel())

    def forget(self, initial_pos: Array, true_pos: Array) -> None:
        """Reset to an estimate at rest at `initial_pos` [m]; world, (3,), both."""
        self.drift[:3], self.drift[3:] = initial_pos - true_pos, 0.0
        self._cov[:] = 0.0
        self._variances[:, 0], self._variances[:, 1] = START_STD**2, START_VEL_STD**2

    def predict(self, acc_noise: Array) -> None:
        """Grow the covariance by one tick; `acc_noise` q of x, y, z [m/s^2], (3,)."""
        self._cov[:] = STEP @ self._cov @ STEP.T
        h = DT / NOISE_STEPS
        noise = np.stack([acc_noise * h * h, acc_noise * h], axis=1) ** 2  # (3, 2)
        self._variances += noise
        self._keep_bounds()
        self._variances += (NOISE_STEPS - 1) * noise
        np.minimum(self._variances, COVARIANCE_MAX, out=self._variances)  # noise reaches no other bound

    def correct(self, measured: Array, true_pos: Array, std: float) -> None:
        """Fuse an external position [m], (3,), with a standard deviation [m]."""
        gain = self._cov[:, :, 0] / (self._cov[:, 0, 0] + std * std)[:, None]  # (3, 2)
        surprise = measured - (true_pos + self.drift[:3])
        self.drift[:3] += gain[:, 0] * surprise
        self.drift[3:] += gain[:, 1] * surprise
        self._cov -= gain[:, :, None] * self._cov[:, None, 0, :]
        self._keep_bounds()

    def correct_by_flow(self, state: Array) -> None:
        """Fuse horizontal velocity and height as a flow deck measures them in a state row."""
        height = self._cov[2]
        gain = height[:, 0] / (height[0, 0] + RANGE_STD**2)
        surprise = -self.drift[2]
        self.drift[2] += gain[0] * surprise
        self.drift[5] += gain[1] * surprise
        self._cov[2] = height - np.outer(gain, height[0])
        std = FLOW_STD * max(float(state[POS][2] + self.drift[2]), FLOW_HEIGHT_MIN)
        ground = self._cov[:2]
        gains = ground[:, :, 1] / (ground[:, 1, 1] + std**2)[:, None]  # (2, 2)
        slip = -self.drift[3:5]
        self.drift[:2] += gains[:, 0] * slip
        self.drift[3:5] += gains[:, 1] * slip
        self._cov[:2] = ground - gains[:, :, None] * ground[:, None, 1, :]
        self._keep_bounds()

    def _keep_bounds(self) -> None:
        np.maximum(self._variances, VARIANCE_MIN, out=self._variances)
        np.minimum(self._cov, COVARIANCE_MAX, out=self._cov)
