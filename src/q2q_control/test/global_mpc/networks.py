"""Networks of time for r, a and U, trained together: (26) in the paper's parameterisation.

Each vehicle has r(t), a(t) = (phi, theta), U1(t) as networks of 30 units (`time_networks`). The equality
constraints that the paper passes to SQP (70 024 for 980 weights, which is infeasible) enter the loss as
defects, minimised by `levenberg_marquardt`:

    loss = sum_k sum_j |r_j - r_j,ref|^2 + w_d |r_j'' - U_j / m b(a_j) + g e_z - eta|^2
                       + w_b (excess of U_j over 0..U_max)^2  + start

r is the reference plus its network, so that the search starts on the plan; a and U1 are hover plus theirs.

| symbol | name | meaning [unit] |
|---|---|---|
| w_d | defect_weight | [s^4]: a defect of 1 m/s^2 over a second moves a vehicle by metres |
| w_b | bound_weight | [m^2/N^2] |
"""

from dataclasses import dataclass

import numpy as np
from global_mpc.levenberg_marquardt import minimise
from global_mpc.problem import (
    GlobalProblem,
    GlobalSolution,
    downwash,
    thrust_acceleration,
)
from global_mpc.time_networks import TimeNetworks

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

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
    fit = NetworkFit(problem, params)
    return fit.solution(minimise(fit, fit.networks.random_weights(rng), params.iterations, params.tolerance))


class NetworkFit:
    """Samples of the problem; maps weights to residuals and their derivatives."""

    def __init__(self, problem: GlobalProblem, params: NetworkSolutionParams) -> None:
        self._problem, self._params = problem, params
        self._n, self._count = problem.reference.shape[0], problem.times.size
        self.networks = TimeNetworks(self._n, problem.times, params.hidden)
        self._spread = 1.0 / np.sqrt(self._count)  # sums become means

    def _flight(self, weights: Array) -> tuple[Array, Array, Array, Array]:
        """Return positions, accelerations (n, T, 3), tilts (n, T, 2), thrusts (n, T)."""
        values, seconds = self.networks.outputs(weights)
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
        values, seconds = self.networks.slopes(weights)
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
        return np.concatenate(rows)[:, self.networks.columns()]

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
