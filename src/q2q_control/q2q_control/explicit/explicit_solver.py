"""Answer a tick's horizon by the explicit law, in place of the solver of q2q_control.mpc.horizon_solver.

All else is the receding horizon's: where vehicles are when a command acts, what pushes along the horizon,
fallbacks. Chains are swept without bounds; the height of each vehicle is then the law's, which looks at it
and at the neighbour whose downwash changes most with their heights. A vehicle that no downwash touches gets a
neighbour on whom nothing acts. So the law needs a vehicle's own state, its neighbour's and both references:
distributed, no solver.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from q2q_control.explicit.features import STAGES
from q2q_control.explicit.law import ExplicitLaw, evaluate_all, packed, scratch_of
from q2q_control.mpc.chain import ChainWeights, chain
from q2q_control.mpc.mpc_params import MpcParams
from q2q_control.mpc.prediction.downwash_horizon import DownwashHorizon
from q2q_control.mpc.prediction.present import axis_lags
from q2q_control.mpc.problem.horizon import SOLVED, Horizon, HorizonSolution
from q2q_control.mpc.receding import Mpc
from q2q_control.mpc.solver.chain_sweep import sweep, sweep_gains
from q2q_model.compiled import compiled
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle

Rows = NDArray[np.intp]


class ExplicitSolver:
    """Explicit law with its work arrays."""

    def __init__(self, law: ExplicitLaw, side: Array) -> None:
        """Answer heights by `law`; `side` are the gains (`sweep_gains`) of the chains of x and y."""
        self._gains = (side, law.gains)
        self._weights, self._sizes = packed(law)
        self._scratch = scratch_of(law)

    def solve(
        self,
        horizon: Horizon,
        downwash: DownwashHorizon,
        guess: NDArray[np.int8],
        in_time: Callable[[], bool],
    ) -> HorizonSolution:
        """Return the answer; there is nothing to start from and nothing that could be late."""
        del guess, in_time
        n = len(horizon.push)
        answer = HorizonSolution(
            pos=np.empty((n, STAGES + 1, 3)),
            inputs=np.empty((n, STAGES, 3)),
            pattern=np.zeros((n, STAGES, 3), np.int8),
            ended=np.full(n, SOLVED, np.int8),
            iterations=1,
        )
        everyone = np.arange(n)
        for axis, gains in zip((0, 1, 2), (self._gains[0], *self._gains), strict=True):
            sweep(horizon, (everyone, np.full(n, axis)), gains, (answer.pos, answer.inputs))
        answer.inputs[:, 0, 2] = self._lifts(horizon, downwash)
        np.clip(answer.inputs, horizon.low[:, None], horizon.high[:, None], out=answer.inputs)
        # the next downwash is looked up where the vehicles are now: so the law was taught
        answer.pos[..., 2] = (
            horizon.reference[..., 2] + (horizon.start[:, 2, 0] - horizon.reference[:, 0, 2])[:, None]
        )
        return answer

    def _lifts(self, horizon: Horizon, downwash: DownwashHorizon) -> Array:
        """Return each vehicle's first command along z [m/s^2], (n,)."""
        ref = horizon.reference
        states = horizon.start[:, 2] - np.stack([ref[:, 0, 2], ref[:, 0, 5], np.zeros(len(ref))], axis=1)
        push = horizon.push[..., 2] - ref[:, :-1, 8]
        other, slope = _neighbours(downwash, len(ref))
        known = (other >= 0)[:, None]
        pairs = (
            np.stack([states, np.where(known, states[other], 0.0)], axis=1),
            np.stack([push, np.where(known, push[other], 0.0)], axis=1),
            slope,
        )
        lifts = evaluate_all(self._weights, self._sizes, pairs, self._scratch)
        return np.asarray(ref[:, 0, 8] + lifts)


def explicit_controller(
    law: ExplicitLaw, params: MpcParams, vehicle: Vehicle, model: InteractionModel
) -> Mpc:
    """Return a receding horizon that is answered by `law`.

    Raises:
        ValueError: the law was distilled for another vehicle, other weights or another horizon.
    """
    z, xy = ChainWeights(params.bandwidth_z, params.jerk), ChainWeights(params.bandwidth_xy, params.jerk)
    lags = axis_lags(params, vehicle)
    own = sweep_gains(chain(lags[2], params.step, z))
    if params.steps != STAGES or not np.allclose(own, law.gains, rtol=1e-6):
        raise ValueError("the explicit law is another vehicle's, or of other weights: distil it for these")
    controller = Mpc(params, vehicle, model)
    controller.solver = ExplicitSolver(law, sweep_gains(chain(lags[0], params.step, xy)))
    return controller


def _neighbours(downwash: DownwashHorizon, n: int) -> tuple[Rows, Array]:
    """Return each vehicle's neighbour or -1, (n,), and the slopes of both interactions, (n, 2, N)."""
    other, both = neighbours((downwash.i, downwash.j, np.ascontiguousarray(downwash.slope[..., 2, 2])), n)
    return other, both


@compiled
def neighbours(downwash: tuple[Rows, Rows, Array], n: int) -> tuple[Rows, Array]:
    """The same of (i, j (pairs,), vertical slopes (pairs, N)): who answers most if heights change."""
    i, j, slope = downwash
    other, strongest = np.full(n, -1), np.zeros(n)
    both = np.zeros((n, 2, slope.shape[1]))
    for pair in range(i.size):
        if i[pair] >= n or j[pair] >= n:
            continue
        strength = np.abs(slope[pair]).max()
        for v, partner in ((i[pair], j[pair]), (j[pair], i[pair])):
            if strength > strongest[v]:
                strongest[v], other[v] = strength, partner
    for pair in range(i.size):
        if i[pair] < n and other[i[pair]] == j[pair]:
            both[i[pair], 0] = slope[pair]
        if j[pair] < n and other[j[pair]] == i[pair]:
            both[j[pair], 1] = slope[pair]
    return other, both
