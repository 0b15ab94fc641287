"""Estimate position, velocity and acceleration from noisy positions: a Kalman filter with white jerk.

Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001,
section 6.2.3. With x = (p, v, a) an axis, one covariance for the three axes of a vehicle:

    x- = F x,  P- = F P F^T + Q,  S = P-_00 + sigma^2,  K = P-_:0 / S,  x = x- + K (r - p-),  P = P- - K P-_0:
    F = [1 tau h tau - h^2/2; 0 1 h; 0 0 1],  h = min(tau, ACC_HORIZON)
    Q = q [tau^5/20 tau^4/8 tau^3/6; tau^4/8 tau^3/3 tau^2/2; tau^3/6 tau^2/2 tau]

h lets a dropout believe the last acceleration for a moment and then coasts at constant velocity.
sigma = 0 gives K_0 = 1: the measured position passes through, the velocity is off by under 4e-5 m/s at
100 Hz where the acceleration swings by 0.5 m/s^2 in a second.

| symbol | name | meaning [unit] |
|---|---|---|
| x | state | rows p v a [m, m/s, m/s^2], columns x y z, (n, 3, 3) |
| P | cov | covariance of (p, v, a), (n, 3, 3) |
| r | measured | measured position [m], (n, 3) |
| sigma^2 | noise_var | variance of r, each axis [m^2] |
| q | density | power density of the jerk [m^2/s^5] |
| tau | elapsed | time to bridge [s], (n,) |
"""

import numpy as np

from q2q_model.signals.values import Array

ACC_HORIZON = 0.05
"""How long a dropout believes the last acceleration [s]: about half a swing of a small vehicle's attitude."""
START_STD = (0.5, 5.0)
"""Standard deviation of velocity [m/s] and acceleration [m/s^2] at a track's first sample."""


def transition(elapsed: Array, density: float) -> tuple[Array, Array]:
    """Return F and Q, (n, 3, 3) each, of time spans `elapsed` [s] (n,)."""
    tau, ones, none = elapsed, np.ones_like(elapsed), np.zeros_like(elapsed)
    h = np.minimum(tau, ACC_HORIZON)
    moved = np.stack([ones, tau, h * (tau - 0.5 * h), none, ones, h, none, none, ones], axis=-1)
    pp, pv, pa, vv, va = tau**5 / 20.0, tau**4 / 8.0, tau**3 / 6.0, tau**3 / 3.0, tau**2 / 2.0
    spread = density * np.stack([pp, pv, pa, pv, vv, va, pa, va, tau], axis=-1)
    return moved.reshape(-1, 3, 3), spread.reshape(-1, 3, 3)


def start(measured: Array, velocity: Array, noise_var: float) -> tuple[Array, Array]:
    """Return state and cov of tracks that begin at `measured` [m] with `velocity` [m/s], (n, 3) each."""
    state = np.stack([measured, velocity, np.zeros_like(measured)], axis=1)
    variances = np.diag([noise_var, START_STD[0] ** 2, START_STD[1] ** 2])
    return state, np.broadcast_to(variances, (len(measured), 3, 3)).copy()


def gain(cov: Array, noise_var: float) -> Array:
    """Return K, (n, 3), of predicted covariances (n, 3, 3)."""
    return np.asarray(cov[:, :, 0] / (cov[:, 0, 0] + noise_var)[:, None])


def correct(state: Array, cov: Array, measured: Array, noise_var: float) -> tuple[Array, Array]:
    """Return state and cov after `measured` [m] (n, 3) is believed."""
    K = gain(cov, noise_var)
    better = state + K[:, :, None] * (measured - state[:, 0])[:, None, :]
    if noise_var == 0.0:
        better[:, 0] = measured  # K_0 = 1 without the rounding
    return better, cov - K[:, :, None] * cov[:, 0, None, :]
