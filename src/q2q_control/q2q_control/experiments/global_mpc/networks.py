"""Networks of time for r, a and U, trained together: (26) in the paper's parameterisation.

Each vehicle has r(t), a(t) = (phi, theta), U1(t) as networks of one hidden layer, tanh, 30 units, of the time
scaled to -1..1. Derivatives of r with respect to time are exact. The equality constraints that the paper
passes to SQP (70 024 for 980 weights, which is infeasible) enter the loss as defects, minimised by
Levenberg-Marquardt:

    loss = sum_k sum_j |r_j - r_j,ref|^2 + w_d |r_j'' - U_j / m b(a_j) + g e_z - eta|^2
                       + w_b (excess of U_j over 0..U_max)^2  + start
    (J' J + mu D) step = -J' residual,  mu down after a success, up after a failure

Levenberg-Marquardt: More, The Levenberg-Marquardt algorithm, Lecture Notes in Mathematics 630, 1978. r is
the reference plus its network, so that the search starts on the plan; a and U1 are hover plus theirs.

| symbol | name | meaning [unit] |
|---|---|---|
| w_d | defect_weight | [s^4]: a defect of 1 m/s^2 over a second moves a vehicle by metres |
| w_b | bound_weight | [m^2/N^2] |
| mu | damping | [-] |
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from q2q_control.experiments.global_mpc.problem import (
    GlobalProblem,
    GlobalSolution,
    downwash,
    thrust_acceleration,
)
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

OUTPUTS = 6
"""Of a vehicle: x y z [m], phi theta [rad], U1 [m g]."""
NUDGE = 1e-5
"""Step of the downwash's central differences [m]."""


@dataclass(frozen=True, slots=True)
class NetworkSolutionParams:
    """Sizes and training parameters of the networks."""

    hidden: int = 30
    """Units of each hidden layer, section 5.2."""
    defect_weight: float = 1.0
    bound_weight: float = 1.0
    iterations: int = 60
    tolerance: float = 1e-5
    """Relative decrease of the loss at which the training ends."""


def solve_networks(
    problem: GlobalProblem, params: NetworkSolutionParams, rng: np.random.Generator
) -> GlobalSolution:
    """Return the solution that the networks reach from random weights."""
    fit = _Fit(problem, params)
    weights = fit.start(rng)
    residual = fit.residual(weights)
    damping, loss = 1e-2, float(residual @ residual)
    for _ in range(params.iterations):
        jacobian = fit.jacobian(weights)
        normal, right = jacobian.T @ jacobian, jacobian.T @ residual
        before = loss
        while damping < 1e8:
            scale = damping * (np.diag(normal) + 1e-9)
            trial = weights - cho_solve(cho_factor(normal + np.diag(scale)), right)
            trial_residual = fit.residual(trial)
            trial_loss = float(trial_residual @ trial_residual)
            if trial_loss < loss:
                weights, residual, loss, damping = trial, trial_residual, trial_loss, damping / 5.0
                break
            damping *= 4.0
        if before - loss <= params.tolerance * before:
            break
    return fit.solution(weights)


class _Fit:
    """Samples of the problem; maps weights to residuals and their derivatives."""

    def __init__(self, problem: GlobalProblem, params: NetworkSolutionParams) -> None:
        self._problem, self._params = problem, params
        self._half = 0.5 * (problem.times[-1] - problem.times[0])
        self._s = (problem.times - problem.times[0]) / self._half - 1.0  # (T,)
        self._n, self._count = problem.reference.shape[0], problem.times.size
        self._spread = 1.0 / np.sqrt(self._count)  # sums become means

    def start(self, rng: np.random.Generator) -> Array:
        """Return random weights whose networks are near zero: (n, OUTPUT groups, 3 h + ...) flattened."""
        h = self._params.hidden
        steep = rng.normal(size=(self._n, 3, h)) * h / 2.0
        centre = -steep * rng.uniform(-1.0, 1.0, (self._n, 3, h))  # kinks all along the flight
        out = np.zeros((self._n, OUTPUTS, h + 1))
        return np.concatenate([steep.ravel(), centre.ravel(), out.ravel()])

    def _parts(self, weights: Array) -> tuple[Array, Array, Array]:
        h, n = self._params.hidden, self._n
        cut = n * 3 * h
        steep = weights[:cut].reshape(n, 3, h)
        centre = weights[cut : 2 * cut].reshape(n, 3, h)
        return steep, centre, weights[2 * cut :].reshape(n, OUTPUTS, h + 1)

    def _outputs(self, weights: Array) -> tuple[Array, Array]:
        """Return the networks' outputs and second time derivatives, (n, T, OUTPUTS)."""
        steep, centre, out = self._parts(weights)
        values, seconds = np.empty((2, self._n, self._count, OUTPUTS))
        for net, columns in enumerate(_NETS):
            hidden = np.tanh(self._s[:, None] * steep[:, None, net] + centre[:, None, net])  # (n, T, h)
            curve = -2.0 * hidden * (1.0 - hidden**2) * (steep[:, None, net] / self._half) ** 2
            for column in columns:
                values[..., column] = (hidden * out[:, None, column, :-1]).sum(-1) + out[:, None, column, -1]
                seconds[..., column] = (curve * out[:, None, column, :-1]).sum(-1)
        return values, seconds

    def _flight(self, weights: Array) -> tuple[Array, Array, Array, Array]:
        """Return positions, accelerations (n, T, 3), tilts (n, T, 2), thrusts (n, T)."""
        values, seconds = self._outputs(weights)
        reference, weight = self._problem.reference, self._problem.vehicle.hover_thrust
        pos, acc = reference[..., :3] + values[..., :3], reference[..., 6:9] + seconds[..., :3]
        tilt = values[..., 3:5] + _tilt_of(reference[..., 6:9])
        return pos, acc, tilt, weight * (1.0 + values[..., 5])

    def residual(self, weights: Array) -> Array:
        """Return all residuals, one vector."""
        pos, acc, tilt, thrust = self._flight(weights)
        vehicle, params = self._problem.vehicle, self._params
        defect = acc - thrust_acceleration(thrust, tilt, vehicle.mass) - downwash(self._problem.model, pos)
        off = pos - self._problem.reference[..., :3]
        excess = np.maximum(thrust - self._problem.thrust_max, 0.0) - np.maximum(-thrust, 0.0)
        first = np.concatenate(
            [off[:, 0], (off[:, 1] - off[:, 0]) / np.diff(self._problem.times[:2])], axis=1
        )
        return np.concatenate(
            [
                self._spread * off.ravel(),
                self._spread * np.sqrt(params.defect_weight) * defect.ravel(),
                self._spread * np.sqrt(params.bound_weight) * excess.ravel(),
                first.ravel(),
            ]
        )

    def jacobian(self, weights: Array) -> Array:
        """Return d residual / d weights by the chain rule through the outputs."""
        values_by_weight, seconds_by_weight = self._output_slopes(weights)
        return self._chain(weights, values_by_weight, seconds_by_weight)

    def _output_slopes(self, weights: Array) -> tuple[Array, Array]:
        """Return d outputs and d second derivatives / d a vehicle's own weights, (n, T, OUTPUTS, own)."""
        steep, centre, out = self._parts(weights)
        h = self._params.hidden
        own = 6 * h + OUTPUTS * (h + 1)
        values, seconds = np.zeros((2, self._n, self._count, OUTPUTS, own))
        s = self._s[None, :, None]
        for net, columns in enumerate(_NETS):
            slope = steep[:, None, net]  # (n, 1, h)
            hidden = np.tanh(s * slope + centre[:, None, net])  # (n, T, h)
            first = 1.0 - hidden**2
            second = -2.0 * hidden * first
            third = first * (6.0 * hidden**2 - 2.0)
            rate = 1.0 / self._half**2
            for column in columns:
                gain = out[:, None, column, :-1]
                at_steep, at_centre = slice(net * h, (net + 1) * h), slice((3 + net) * h, (4 + net) * h)
                values[..., column, at_centre] = gain * first
                values[..., column, at_steep] = gain * first * s
                seconds[..., column, at_centre] = gain * third * slope**2 * rate
                seconds[..., column, at_steep] = gain * (third * s * slope**2 + 2.0 * second * slope) * rate
                place = 6 * h + column * (h + 1)
                values[..., column, place : place + h] = hidden
                values[..., column, place + h] = 1.0
                seconds[..., column, place : place + h] = second * slope**2 * rate
        return values, seconds

    def _chain(self, weights: Array, values: Array, seconds: Array) -> Array:
        n, count, own = self._n, self._count, values.shape[-1]
        pos, _, tilt, thrust = self._flight(weights)
        by_downwash = self._downwash_slopes(pos)  # (n, n, T, 3, 3)
        by_tilt, by_thrust = _thrust_slopes(thrust, tilt, self._problem.vehicle.mass)
        weight = self._problem.vehicle.hover_thrust
        off, defect = np.zeros((n, count, 3, n, own)), np.zeros((n, count, 3, n, own))
        excess = np.zeros((n, count, n, own))
        active = (thrust > self._problem.thrust_max) | (thrust < 0.0)
        for i in range(n):
            off[i, :, :, i] = values[i, :, :3]
            defect[i, :, :, i] = seconds[i, :, :3]
            defect[i, :, :, i] -= np.einsum("tab,tbw->taw", by_tilt[i], values[i, :, 3:5])  # by tilt
            defect[i, :, :, i] -= (by_thrust[i] * weight)[:, :, None] * values[i, :, None, 5]
            excess[i, :, i] = active[i][:, None] * weight * values[i, :, 5]
            for j in range(n):
                defect[i, :, :, j] -= np.einsum(
                    "tab,tbw->taw", by_downwash[i, j], values[j, :, :3]
                )  # d eta / d r
        step = self._problem.times[1] - self._problem.times[0]
        first = np.concatenate([off[:, 0], (off[:, 1] - off[:, 0]) / step], axis=1)
        params, spread = self._params, self._spread
        rows = [
            spread * off.reshape(-1, n * own),
            spread * np.sqrt(params.defect_weight) * defect.reshape(-1, n * own),
            spread * np.sqrt(params.bound_weight) * excess.reshape(-1, n * own),
            first.reshape(-1, n * own),
        ]
        return np.concatenate(rows)[:, self._order()]

    def _order(self) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
        """Return which column (vehicle by vehicle) belongs to each weight of the flat vector."""
        h, n = self._params.hidden, self._n
        own = 6 * h + OUTPUTS * (h + 1)
        columns = np.arange(n * own).reshape(n, own)
        parts = (columns[:, : 3 * h], columns[:, 3 * h : 6 * h], columns[:, 6 * h :])
        return np.concatenate([part.ravel() for part in parts])

    def _downwash_slopes(self, pos: Array) -> Array:
        """Return d eta_i / d r_j, (n, n, T, 3 feels, 3 moves)."""
        slopes = np.empty((self._n, self._n, self._count, 3, 3))
        for j in range(self._n):
            for axis in range(3):
                nudge = np.zeros_like(pos)
                nudge[j, :, axis] = NUDGE
                up, down = (downwash(self._problem.model, pos + sign * nudge) for sign in (1.0, -1.0))
                slopes[:, j, :, :, axis] = (up - down) / (2.0 * NUDGE)
        return slopes

    def solution(self, weights: Array) -> GlobalSolution:
        """Return the flight of the networks."""
        pos, acc, tilt, thrust = self._flight(weights)
        by_thrust = thrust_acceleration(thrust, tilt, self._problem.vehicle.mass)
        return GlobalSolution(pos, thrust, acc - by_thrust - downwash(self._problem.model, pos))


_NETS = ((0, 1, 2), (3, 4), (5,))
"""Which outputs each network has: r, a, U1."""


def _tilt_of(acc: Array) -> Array:
    """Return roll and pitch [rad], (..., 2), that hold a reference's acceleration (..., 3)."""
    vertical = GRAVITY + acc[..., 2]
    pitch = np.arctan2(acc[..., 0], vertical)
    return np.stack([np.arctan2(-acc[..., 1], np.hypot(acc[..., 0], vertical)), pitch], axis=-1)


def _thrust_slopes(thrust: Array, tilt: Array, mass: float) -> tuple[Array, Array]:
    """Return the thrust acceleration's derivatives by roll, pitch (n, T, 3, 2), and by U1 (n, T, 3)."""
    roll, pitch = tilt[..., 0], tilt[..., 1]
    cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
    by_roll = np.stack([-sr * sp, -cr, -sr * cp], axis=-1)
    by_pitch = np.stack([cr * cp, np.zeros_like(cr), -cr * sp], axis=-1)
    by_tilt = np.stack([by_roll, by_pitch], axis=-1) * (thrust / mass)[..., None, None]
    return by_tilt, np.stack([cr * sp, -sr, cr * cp], axis=-1) / mass
