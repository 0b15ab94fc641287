"""Kalman filter of height, climb rate and unexplained push, from positions and accelerometers.

    z' = v,   v' = a + w + b                        a: by thrust and by the predicted downwash
    w' = -w / T + white noise,    E w^2 = sigma^2     residual of the prediction (ResidualProcess)
    b' = white noise of density 2 sigma_b^2 / T_b     offset of the vehicle: battery, mass
    c' = white noise of density 2 sigma_c^2 / T_c     bias of the accelerometer
    z_m = z + n_z,   y = w + b + c + n_y            motion capture; specific force less thrust and prediction

Incremental control (Smeur, Chu, de Croon, J. Guid. Control Dyn. 39, 2016; Smeur, de Croon, Chu, Control Eng.
Pract. 73, 2018) filters the measured acceleration, and the thrust alike, by a low pass of choice. Here both
pass the same filter too, since it takes their difference, and the process sets its bandwidth: sigma grows
with the downwash, so turbulence under a wake is followed at once and noise in clear air is not. From y alone,

    w^ <- a w^ + k (y - a w^),   k = P / (P + R),   P = a^2 (1 - k) P + (1 - a^2) sigma^2,   a = exp(-h / T)

With y missing, the positions correct alone: an observer of disturbances with the poles that the process sets.
A sample y of age s is one of exp(-s / T) w with the variance R + (1 - exp(-2 s / T)) sigma^2, so an older one
weighs less. With both missing w^ fades within T, and the model and the offset remain. Thrust enters as
commanded, limits included, so nothing winds up at a limit. While thrust does not carry the vehicle
(q2q_model.downwash.correction.carried_by_rotors), as on the ground, z and v are as measured, w^ fades, and
b^ and c^ stay.

b moves the vehicle and c does not, so the positions separate them, within seconds. Without c, a bias of
0.05 m/s^2 would be taken for a push: 6 cm of height for a loop of 0.8 m/s^2 per metre.

| symbol | name | meaning [unit] |
|---|---|---|
| z v | HEIGHT CLIMB | [m], [m/s] |
| w b c | RESIDUAL OFFSET BIAS | [m/s^2] |
| sigma T R | process.std, time_s, noise^2 | of the residual process |
| n_z | HEIGHT_STD | [m] |
| sigma_b T_b | OFFSET_STD OFFSET_S | [m/s^2], [s] |
| sigma_c T_c | BIAS_STD BIAS_S | [m/s^2], [s] |
"""

from typing import NamedTuple

import numpy as np

from q2q_control.disturbance.observer import GAP_MAX, Measurement
from q2q_model.compiled import compiled
from q2q_model.downwash.correction.corrected_predictor import OFFSET_S
from q2q_model.downwash.correction.residual_process import OLDEST, ResidualProcess
from q2q_model.signals.values import Array, Mask, Names, rows_by_name

HEIGHT_STD = 1e-3
"""Deviation of a measured height [m], as in the mocap filter (VICON: 0.15 mm static, under 2 mm dynamic)."""
CLIMB_STD = 0.1
"""Deviation of the first climb rate [m/s]: that of the mocap filter on its first track."""
OFFSET_STD = 0.3
"""Deviation of the first offset, and of its change within OFFSET_S [m/s^2]: 0.1 to 0.3 in real flights."""
BIAS_STD = 0.1
"""Deviation of the first bias, and of its change within BIAS_S [m/s^2]: 0.1 on recorded flights."""
BIAS_S = 600.0
"""Time constant of c [s]: an accelerometer warms up within minutes."""
HEIGHT, CLIMB, RESIDUAL, OFFSET, BIAS = range(5)
"""Columns of the state."""


class ResidualEstimate(NamedTuple):
    """Estimated state of every vehicle and its covariance."""

    state: Array
    """z v w b c, (n, 5)."""
    cov: Array
    """(n, 5, 5)"""


class ResidualRows(NamedTuple):
    """Measurements of a tick, (n,) each."""

    height: Array
    climb: Array
    acc: Array
    """By thrust and predicted downwash, mean since the last tick [m/s^2]."""
    sigma: Array
    """[m/s^2]"""
    fresh: Mask
    """Rows whose height was measured at this tick."""
    carried: Mask
    """Rows of vehicles that their rotors carry."""


class ResidualObserver:
    """Filter of named vehicles."""

    def __init__(self, process: ResidualProcess) -> None:
        """Correct a prediction whose residual is `process`."""
        self._process = process
        self.reset()

    def reset(self) -> None:
        """Forget all estimates."""
        self._names: Names = ()
        self._t = self._sampled_at = -np.inf
        self._known: Mask = np.zeros(0, np.bool_)
        self._sigma = np.zeros(0)
        self.estimate = ResidualEstimate(np.zeros((0, 5)), np.zeros((0, 5, 5)))

    def update(self, measured: Measurement, eta: Array, carried: Mask) -> Array:
        """Return the state at the measurement's time, (n, 5).

        Args:
            measured: of every vehicle.
            eta: predicted downwash [m/s^2], (n,).
            carried: vehicles that their rotors carry, (n,).
        """
        if measured.names != self._names:
            self._reorder(measured.names)
        step, self._t = measured.t - self._t, measured.t
        if not 0.0 < step <= GAP_MAX:
            self._known[:] = False
            step = GAP_MAX  # of no consequence: no row is known
        self._sigma = self._process.std(eta)
        *motion, fresh = measured.rows
        height, climb, acc = (column[:, 2].copy() for column in motion)
        rows = ResidualRows(height, climb, acc, self._sigma, fresh, carried)
        predict_and_correct(self.estimate, self._known, rows, step, self._process.correlation(step))
        self._known |= fresh
        return self.estimate.state.copy()

    def correct_by_accelerometer(self, t: float, push: Array) -> None:
        """Correct by y [m/s^2], (n,), of time t [s], in the order of the last update; NaN where unknown.

        A sample not later than the last, of the future, or older than `OLDEST` is ignored.
        """
        age = self._t - t
        if t <= self._sampled_at or not 0.0 <= age <= OLDEST:
            return
        self._sampled_at, share = t, self._process.correlation(age)
        noise = self._process.noise**2 + (1.0 - share**2) * self._sigma**2
        correct_by_push(self.estimate, self._known & np.isfinite(push), push, noise, share)

    def _reorder(self, names: Names) -> None:
        have, old = self._names, self.estimate
        self._known = rows_by_name(self._known, have, names)
        self.estimate = ResidualEstimate(
            rows_by_name(old.state, have, names), rows_by_name(old.cov, have, names)
        )
        self._names = names


@compiled
def predict_and_correct(
    estimate: ResidualEstimate, known: Mask, rows: ResidualRows, step: float, share: float
) -> None:
    """Propagate by a step [s] and correct by heights, in place; rows that are not `known` (n,) are reset.

    `share` is what remains of w [-].
    """
    half = 0.5 * step * step
    F = np.eye(5)
    F[0, 1], F[0, 2], F[0, 3], F[1, 2], F[1, 3], F[2, 2] = step, half, half, step, step, share
    see = np.array([1.0, 0.0, 0.0, 0.0, 0.0])
    for i in range(rows.height.size):
        x, P = estimate.state[i], estimate.cov[i]
        if not known[i]:
            _start(x, P, rows, i)
            continue
        _propagate(x, P, F, rows.acc[i], rows.sigma[i])
        if rows.fresh[i] and not rows.carried[i]:
            _restart_motion(x, P, rows, i)
        elif rows.fresh[i]:
            _correct(x, P, see, rows.height[i], HEIGHT_STD**2)


@compiled
def _start(x: Array, P: Array, rows: ResidualRows, i: int) -> None:
    """Write x (5,) and P (5, 5) of a vehicle that was not known: its height and climb rate, and zeros."""
    x[:], P[:] = 0.0, 0.0
    P[2, 2], P[3, 3], P[4, 4] = rows.sigma[i] ** 2, OFFSET_STD**2, BIAS_STD**2
    _restart_motion(x, P, rows, i)


@compiled
def _restart_motion(x: Array, P: Array, rows: ResidualRows, i: int) -> None:
    """Set height and climb rate of x (5,) and P (5, 5) to those measured."""
    x[0], x[1] = rows.height[i], rows.climb[i]
    P[:2], P[:, :2] = 0.0, 0.0
    P[0, 0], P[1, 1] = HEIGHT_STD**2, CLIMB_STD**2


@compiled
def _propagate(x: Array, P: Array, F: Array, acc: float, sigma: float) -> None:
    """Move x (5,) and P (5, 5) on by a step, whose transition is F (5, 5), under `acc` [m/s^2]."""
    step, half, share = F[0, 1], F[0, 2], F[2, 2]
    x[:] = F @ x
    x[0] += half * acc
    x[1] += step * acc
    P[:] = F @ P @ F.T
    P[2, 2] += (1.0 - share**2) * sigma**2
    P[3, 3] += 2.0 * step / OFFSET_S * OFFSET_STD**2
    P[4, 4] += 2.0 * step / BIAS_S * BIAS_STD**2


@compiled
def correct_by_push(estimate: ResidualEstimate, rows: Mask, push: Array, noise: Array, share: float) -> None:
    """Correct `rows` (n,) in place by y [m/s^2], (n,), samples of share w + b + c.

    `noise` (n,) is their variance [m^2/s^4].
    """
    see = np.array([0.0, 0.0, share, 1.0, 1.0])
    for i in range(push.size):
        if rows[i]:
            _correct(estimate.state[i], estimate.cov[i], see, push[i], noise[i])


@compiled
def _correct(x: Array, P: Array, see: Array, measured: float, noise: float) -> None:
    """Correct x (5,) and P (5, 5) by a measurement of see . x."""
    shared = P @ see
    variance = see @ shared + noise
    missed = measured - see @ x
    for i in range(5):
        x[i] += shared[i] * missed / variance
        for j in range(5):
            P[i, j] -= shared[i] * shared[j] / variance
