"""Plan as the paper does, for comparison: trajectories as small networks, (18) by SLSQP, section 4.1.

r_j(t) = V_j tanh(w_j s + b_j) + c_j with s = t / T, one hidden layer of 30 units, for each vehicle. Time
derivatives are exact, for y = tanh(z) has d^k y / dz^k = P_k(y) with P_0 = y, P_(k+1) = P_k' (1 - y^2):

    d^k r / ds^k = sum_h V_h w_h^k P_k(y_h)

and so are the gradients, by d P_k / dz = P_(k+1). The integral is a trapezoidal sum over a grid, on which the
zone is required too, as max(dxy^2 / eps^2 - 1, dz^2 / d^2 - 1) >= 0: the paper's indicator has no gradient.
Derivatives 1..3 vanish at every waypoint (a 4th has no trace under a snap cost). Yaw, which is at rest in
section 4.1, is left out. SLSQP has no `xtol`: Table 5's is dropped.

Nothing that flies uses this: `avoidance` solves the same problem. It shows what the paper's way reaches.

| symbol | name | meaning [unit] |
|---|---|---|
| w, b | w, b | hidden weights and biases, (30,) each |
| V, c | V, c | output weights (30, 3) and offsets (3,) [m] |
"""

from collections.abc import Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import minimize

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array
from q2q_planner.offline.minimum_snap.minimum_snap import POSITION_HALF
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints

UNITS = 30
"""Hidden units; the paper, section 4.1."""
FTOL = 1e-8
"""Table 5."""
GRID = 101
"""Samples of the integral and of the zone."""
SIZE = 5 * UNITS + 3
"""Parameters a vehicle: w, b, V, c."""
BALANCE = 0.1 ** np.arange(POSITION_HALF)
"""Weights of the pinned derivatives in scaled time: SLSQP balances what is of one size."""
LAST = POSITION_HALF
"""Highest derivative in the cost."""


def _tanh_polynomials() -> list[Polynomial]:
    found = [Polynomial([0.0, 1.0])]
    for _ in range(LAST + 1):
        found.append(found[-1].deriv() * Polynomial([1.0, 0.0, -1.0]))
    return found


P = _tanh_polynomials()


@dataclass(frozen=True, slots=True)
class NeuralPlan:
    """End of SLSQP."""

    cost: float
    """(18), by the trapezoidal sum."""
    waypoint_error: float
    """Largest violation of a waypoint [m]."""
    zone_error: float
    """Largest violation of the zone on the grid, as a share of its squared size."""
    iterations: int
    converged: bool
    cpu: float
    """Processor time [s]."""


class _OutOfTimeError(Exception):
    """End SLSQP from its callback."""


def plan_neural(swarm: Sequence[VehicleWaypoints], zone: Cylinder | None, longest: float) -> NeuralPlan:
    """Return the least violating point that SLSQP reaches in `longest` seconds of processor time."""
    problem = _Problem(swarm, zone)
    begun, passed, converged = process_time(), [problem.start(np.random.default_rng(0))], False

    def watch(x: Array) -> None:
        passed.append(x.copy())
        if process_time() - begun > longest:
            raise _OutOfTimeError

    constraints = [{"type": "eq", "fun": problem.pinned, "jac": problem.pinned_jacobian}]
    if zone is not None:
        constraints.append({"type": "ineq", "fun": problem.outside, "jac": problem.outside_jacobian})
    try:
        solved = minimize(
            problem.cost,
            passed[0],
            jac=problem.cost_gradient,
            method="SLSQP",
            constraints=constraints,
            callback=watch,
            options={"ftol": FTOL, "maxiter": 100_000},
        )
        converged = bool(solved.success)
        passed.append(solved.x)
    except _OutOfTimeError:
        pass
    cpu, best = process_time() - begun, min(passed, key=problem.violation)
    return problem.judged(best, len(passed) - 1, converged=converged, cpu=cpu)


class _Problem:
    """Build (18) over the parameters of all vehicles, in scaled time."""

    def __init__(self, swarm: Sequence[VehicleWaypoints], zone: Cylinder | None) -> None:
        self.swarm, self.zone = swarm, zone
        self.end = max(vehicle.times[-1] for vehicle in swarm)
        self.grid = np.linspace(0.0, 1.0, GRID)
        self.weight = np.full(GRID, self.end / (GRID - 1))
        self.weight[[0, -1]] *= 0.5
        self.scale = self.end ** -float(LAST)  # snap per scaled snap
        self.unit = 1e3  # SLSQP's ftol is absolute: the cost of section 4.1 is some 1e-3

    def start(self, generator: np.random.Generator) -> Array:
        """Return random weights with the kinks of the units spread over the flight."""
        parts = []
        for vehicle in self.swarm:
            w = generator.uniform(2.0, 6.0, UNITS)
            b = -w * generator.uniform(0.0, 1.0, UNITS)
            parts += [w, b, 0.1 * generator.normal(size=3 * UNITS), vehicle.points[:, :3].mean(axis=0)]
        return np.concatenate(parts)

    def cost(self, x: Array) -> float:
        """Return (18) times `unit`."""
        snaps = (self._read(x, v, self.grid, LAST)[0] for v in range(len(self.swarm)))
        total = sum(float(self.weight @ (snap**2).sum(-1)) for snap in snaps)
        return float(self.unit * self.scale**2 * total)

    def cost_gradient(self, x: Array) -> Array:
        """Return its gradient, (vehicles * SIZE,)."""
        parts = []
        for v in range(len(self.swarm)):
            snap, jacobian = self._read(x, v, self.grid, LAST)
            parts.append(2.0 * np.einsum("t,ta,tap->p", self.weight, snap, jacobian))
        return np.asarray(self.unit * self.scale**2 * np.concatenate(parts))

    def pinned(self, x: Array) -> Array:
        """Return the violations of waypoints and of rest at them."""
        return np.concatenate([part.ravel() for part, _ in self._pins(x)])

    def pinned_jacobian(self, x: Array) -> Array:
        """Return their Jacobian."""
        return self._spread([jacobian.reshape(-1, SIZE) for _, jacobian in self._pins(x)])

    def outside(self, x: Array) -> Array:
        """Return max(dxy^2 / eps^2 - 1, dz^2 / d^2 - 1) of each pair on the grid."""
        return np.concatenate([value for *_, value, _ in self._pairs(x)])

    def outside_jacobian(self, x: Array) -> Array:
        """Return its Jacobian."""
        rows = []
        for i, j, _, slope in self._pairs(x):
            row = np.zeros((GRID, len(self.swarm) * SIZE))
            for v, sign in ((i, 1.0), (j, -1.0)):
                jacobian = self._read(x, v, self.grid, 0)[1]
                row[:, v * SIZE : (v + 1) * SIZE] = sign * np.einsum("ta,tap->tp", slope, jacobian)
            rows.append(row)
        return np.concatenate(rows)

    def violation(self, x: Array) -> float:
        """Return the largest violation of any constraint, as SLSQP sees it."""
        worst = float(np.abs(self.pinned(x)).max())
        return max(worst, -float(self.outside(x).min())) if self.zone else worst

    def judged(self, x: Array, iterations: int, *, converged: bool, cpu: float) -> NeuralPlan:
        """Return what a solution is worth."""
        pins = [part for part, _ in self._pins(x)]
        return NeuralPlan(
            cost=self.cost(x) / self.unit,
            waypoint_error=max(float(np.abs(part[0]).max()) for part in pins),
            zone_error=max(0.0, -float(self.outside(x).min())) if self.zone else 0.0,
            iterations=iterations,
            converged=converged,
            cpu=cpu,
        )

    def _pins(self, x: Array) -> list[tuple[Array, Array]]:
        """Return derivatives 0..3 at the waypoints less what they should be, and Jacobians."""
        found = []
        for v, vehicle in enumerate(self.swarm):
            read = [self._read(x, v, vehicle.times / self.end, k) for k in range(LAST)]
            values = np.stack([value for value, _ in read])  # (4, waypoints, 3)
            values[0] -= vehicle.points[:, :3]
            jacobians = np.stack([jacobian for _, jacobian in read])
            found.append((values * BALANCE[:, None, None], jacobians * BALANCE[:, None, None, None]))
        return found

    def _pairs(self, x: Array) -> list[tuple[int, int, Array, Array]]:
        """Return for each pair (i, j) the zone's function on the grid and its slope by r_i - r_j."""
        assert self.zone is not None
        found = []
        pos = [self._read(x, v, self.grid, 0)[0] for v in range(len(self.swarm))]
        for i in range(len(pos)):
            for j in range(i + 1, len(pos)):
                rel = pos[i] - pos[j]
                flat = (rel[:, :2] ** 2).sum(-1) / self.zone.eps**2 - 1.0
                high = rel[:, 2] ** 2 / self.zone.d**2 - 1.0
                beside = 2.0 * rel * [self.zone.eps**-2, self.zone.eps**-2, 0.0]
                above = 2.0 * rel * [0.0, 0.0, self.zone.d**-2]
                slope = np.where((flat >= high)[:, None], beside, above)
                found.append((i, j, np.maximum(flat, high), slope))
        return found

    def _spread(self, blocks: list[Array]) -> Array:
        rows = sum(len(block) for block in blocks)
        whole, row = np.zeros((rows, len(blocks) * SIZE)), 0
        for v, block in enumerate(blocks):
            whole[row : row + len(block), v * SIZE : (v + 1) * SIZE] = block
            row += len(block)
        return whole

    def _read(self, x: Array, vehicle: int, s: Array, k: int) -> tuple[Array, Array]:
        """Return d^k r / ds^k at times s (t,), (t, 3), and its Jacobian (t, 3, SIZE)."""
        own = x[vehicle * SIZE : (vehicle + 1) * SIZE]
        w, b, V = own[:UNITS], own[UNITS : 2 * UNITS], own[2 * UNITS : 5 * UNITS].reshape(UNITS, 3)
        y = np.tanh(s[:, None] * w + b)
        here, ahead = w**k * P[k](y), w**k * P[k + 1](y)  # (t, units)
        value = here @ V + (own[5 * UNITS :] if k == 0 else 0.0)
        by_w = (k * w ** max(k - 1, 0) * P[k](y) if k else 0.0) + ahead * s[:, None]
        jacobian = np.zeros((len(s), 3, SIZE))
        jacobian[:, :, :UNITS] = by_w[:, None, :] * V.T
        jacobian[:, :, UNITS : 2 * UNITS] = ahead[:, None, :] * V.T
        for axis in range(3):
            jacobian[:, axis, 2 * UNITS + axis : 5 * UNITS : 3] = here
        if k == 0:
            jacobian[:, :, 5 * UNITS :] = np.eye(3)
        return value, jacobian
