"""Explicit law in place of the solver of q2q_control.mpc.solver.horizon_solver.

Everything else is the receding horizon's: latency, downwash along the horizon, fallbacks. All axes are
swept without bounds; the first command along z is then the law's, of the vehicle and the neighbour whose
downwash is most sensitive to their heights. A vehicle without downwash gets a neighbour that nothing pushes.
The law thus needs a vehicle's own state, its neighbour's and both references: it is distributed and needs no
solver.
"""

import numpy as np

from q2q_control.attitude.thrust_vector import largest_thrust
from q2q_control.explicit_mpc.explicit_law import ExplicitLaw, evaluate_all, weights_of, workspace_of
from q2q_control.explicit_mpc.features import STAGES, PairHorizon
from q2q_control.mpc.mpc import SolverFactory
from q2q_control.mpc.problem.axis_model import axis_models
from q2q_control.mpc.problem.horizon import DownwashHorizon, Horizon, HorizonSolution, blank_solution
from q2q_control.mpc.problem.input_bounds import level_bounds
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.mpc.solver.active_set import ActiveSet
from q2q_control.mpc.solver.axis_sweep import AxisGains, gains_table, sweep_axes, sweep_gains
from q2q_control.mpc.solver.horizon_solver import InTime
from q2q_model.compiled import compiled
from q2q_model.signals.values import Array, Rows
from q2q_model.vehicle.constants import Vehicle


class ExplicitSolver:
    """Explicit law with its work arrays."""

    def __init__(self, law: ExplicitLaw, side: AxisGains) -> None:
        """Command heights by `law`; `side` are the gains of the axes of x and y."""
        self._gains = np.stack([gains_table(side), gains_table(side), law.gains])
        self._weights, self._work = weights_of(law), workspace_of(law)

    def solve(
        self, horizon: Horizon, downwash: DownwashHorizon, warm_start: ActiveSet, in_time: InTime
    ) -> HorizonSolution:
        """Return the solution; warm start and time budget are not needed."""
        del warm_start, in_time
        n = len(horizon.push)
        solution = blank_solution(n, STAGES)
        sweep_axes(horizon, np.ones((n, 3), dtype=np.bool_), self._gains, solution)
        solution.inputs[:, 0, 2] = self._first_commands(horizon, downwash)
        np.clip(solution.inputs, horizon.low[:, None], horizon.high, out=solution.inputs)
        # the next downwash is predicted along paths parallel to the references, as in the law's training
        solution.pos[..., 2] = (
            horizon.reference[..., 2] + (horizon.start[:, 2, 0] - horizon.reference[:, 0, 2])[:, None]
        )
        return solution

    def _first_commands(self, horizon: Horizon, downwash: DownwashHorizon) -> Array:
        """Return each vehicle's first command along z [m/s^2], (n,)."""
        ref = horizon.reference
        states = horizon.start[:, 2] - np.stack([ref[:, 0, 2], ref[:, 0, 5], np.zeros(len(ref))], axis=1)
        push = horizon.push[..., 2] - ref[:, :-1, 8]
        vertical = np.ascontiguousarray(downwash.gradient[..., 2, 2])
        other, gradient = neighbours((downwash.i, downwash.j), vertical, len(ref))
        known = (other >= 0)[:, None]
        pairs = PairHorizon(
            np.stack([states, np.where(known, states[other], 0.0)], axis=1),
            np.stack([push, np.where(known, push[other], 0.0)], axis=1),
            gradient,
        )
        return evaluate_all(self._weights, pairs, self._work)


def explicit_solver(law: ExplicitLaw) -> SolverFactory:
    """Return the solver of an Mpc that commands heights by `law`.

    It raises ValueError for a vehicle, thrust, weights or a horizon other than those of the law.
    """

    def solver(params: MpcParams, vehicle: Vehicle) -> ExplicitSolver:
        side, _, z = axis_models(params, vehicle)
        thrust = largest_thrust(vehicle, params.thrust_max if params.thrust_limited else None)
        bounds = level_bounds(thrust / vehicle.mass)
        same_gains = np.allclose(gains_table(sweep_gains(z)), law.gains, rtol=1e-6)
        if params.steps != STAGES or not same_gains or not np.allclose(bounds, law.bounds, rtol=1e-6):
            raise ValueError(
                "the explicit law is for another vehicle, thrust or weights: distil it for these"
            )
        return ExplicitSolver(law, sweep_gains(side))

    return solver


@compiled
def neighbours(pairs: tuple[Rows, Rows], gradient: Array, n: int) -> tuple[Rows, Array]:
    """Return each vehicle's neighbour of largest gradient, or -1, (n,), and the gradients both ways.

    `pairs` are i and j, (p,) each, and `gradient` (p, N) is the vertical one [1/s^2]. Those both ways are
    (n, 2, N): of what a vehicle feels from its neighbour, and of what that feels from it.
    """
    i, j = pairs
    other, strongest = np.full(n, -1), np.zeros(n)
    both = np.zeros((n, 2, gradient.shape[1]))
    for pair in range(i.size):
        if i[pair] >= n or j[pair] >= n:
            continue
        strength = np.abs(gradient[pair]).max()
        for v, partner in ((i[pair], j[pair]), (j[pair], i[pair])):
            if strength > strongest[v]:
                strongest[v], other[v] = strength, partner
    for pair in range(i.size):
        if i[pair] < n and other[i[pair]] == j[pair]:
            both[i[pair], 0] = gradient[pair]
        if j[pair] < n and other[j[pair]] == i[pair]:
            both[j[pair], 1] = gradient[pair]
    return other, both
