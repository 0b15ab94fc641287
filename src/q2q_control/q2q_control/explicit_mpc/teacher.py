"""Receding horizon as the teacher of the explicit law: many pairs solved at once, in one compiled loop.

Each situation is solved with the downwash linearised again along its solution, so solutions do not depend on
the past; after two rounds they have converged to 1e-4 m/s^2. Heights are errors from the references
(`features`). A source's position is that of a delay ago, by its speed at that stage.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from q2q_control.explicit_mpc.features import STAGES, PairHorizon
from q2q_control.explicit_mpc.situations import Situations
from q2q_control.mpc.prediction.downwash_horizon_kernel import DELTA
from q2q_control.mpc.problem.axis_cost import AxisWeights
from q2q_control.mpc.problem.axis_model import AxisModel, axis_model
from q2q_control.mpc.problem.horizon import DownwashHorizon, Horizon
from q2q_control.mpc.problem.input_bounds import level_bounds
from q2q_control.mpc.problem.joint_problem import GroupShape, group_shape, joint_problem
from q2q_control.mpc.problem.mpc_params import MpcParams
from q2q_control.mpc.solver.active_set import ActiveSet
from q2q_control.mpc.solver.riccati import solve_from
from q2q_model.compiled import compiled
from q2q_model.downwash.interaction_model import (
    InteractionModel,
    SourceStates,
    downwash_ended,
    pairs_at_rest,
    retarded_pairs,
)
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle

ROUNDS = 2
"""Linearisations of each solution."""
ITERATIONS = 60
"""Most recursions of each solve: there is no time limit."""


@dataclass(frozen=True, slots=True)
class Teacher:
    """MPC that the law is distilled from."""

    params: MpcParams
    vehicle: Vehicle
    model: InteractionModel
    thrust_max: float
    """[N]"""

    def __post_init__(self) -> None:
        """Check that the law's windows fit the horizon."""
        if self.params.steps != STAGES:
            raise ValueError(f"steps = {self.params.steps}; must be {STAGES} for the explicit law")

    @property
    def bounds(self) -> tuple[float, float]:
        """Return the least and largest vertical acceleration command of a level vehicle [m/s^2]."""
        return level_bounds(self.thrust_max / self.vehicle.mass)

    @property
    def altitude_model(self) -> AxisModel:
        """Return the model of the altitude axis."""
        params = self.params
        return axis_model(
            self.vehicle.thrust_lag, params.step, AxisWeights(params.bandwidth_z, params.jerk_weight)
        )


class TeacherSolution(NamedTuple):
    """Solutions of K situations."""

    inputs: Array
    """First commands of both vehicles, their references' accelerations included [m/s^2], (K, 2)."""
    errors: Array
    """Predicted height errors [m], (K, 2, N + 1)."""
    active_set: ActiveSet
    """Active bounds, (K, N, 2)."""


class _Limits(NamedTuple):
    """Bounds of the input and of its lead over the acceleration [m/s^2]."""

    low: float
    high: float
    slew_max: float


def solve_situations(
    situations: Situations, teacher: Teacher, errors: Array | None = None
) -> TeacherSolution:
    """Return the solutions; `errors` (K, 2, N + 1) [m] are heights of the first linearisation."""
    count, params, model = len(situations.states), teacher.params, teacher.altitude_model
    shape = group_shape(2, (2,), (model, model, model), params.terminal_weight)
    slew_max = params.thrust_rate_max * params.step / (1.0 - float(model.transition[2, 2]))
    found = TeacherSolution(
        np.zeros((count, 2)),
        np.zeros((count, 2, STAGES + 1)) if errors is None else errors.copy(),
        np.zeros((count, STAGES, 2), np.int8),
    )
    for _ in range(ROUNDS):
        eta, gradient = downwash_between(situations.paths, found.errors, teacher)
        pairs = PairHorizon(situations.states, eta + situations.extra, gradient)
        _solve_all(shape, pairs, _Limits(*teacher.bounds, slew_max), found)
    return found


def pair_horizon(situations: Situations, teacher: Teacher) -> PairHorizon:
    """Return the law's view of situations, with downwash along paths parallel to the references."""
    eta, gradient = downwash_between(situations.paths, situations.states[..., :1], teacher)
    return PairHorizon(situations.states, eta + situations.extra, gradient)


def downwash_between(paths: Array, errors: Array, teacher: Teacher) -> tuple[Array, Array]:
    """Return the downwash of pairs at the stages' middles, and their gradients, (..., 2, N) each.

    `paths` (..., 2, N + 1, 3) are references, `errors` (..., 2, N + 1 or 1) heights above them [m].
    """
    model, path = teacher.model, paths.copy()
    path[..., 2] += errors
    here = 0.5 * (path[..., 1:, :] + path[..., :-1, :])
    vel = np.diff(path, axis=-2) / teacher.params.step
    rel = here[..., ::-1, :, :] - here
    now = SourceStates(
        rel, vel[..., ::-1, :, :], pairs_at_rest(rel).source_axis
    )  # as seen from the exposed vehicle
    pairs = retarded_pairs(
        model,
        np.zeros_like(rel),
        vel,
        now,
        lambda delay: replace(now, pos=now.pos - now.vel * delay[..., None]),
    )
    felt, nudge = ~downwash_ended(pairs, model.reach), np.array([0.0, 0.0, DELTA])
    places = (pairs.rel_pos + side * nudge for side in (0.0, 1.0, -1.0))
    eta, above, below = (np.where(felt, model.acceleration(one, pairs.motion)[..., 2], 0.0) for one in places)
    gradient = (above - below) / (2.0 * DELTA)
    return eta, np.clip(gradient, -teacher.params.slope_max, teacher.params.slope_max)


@compiled
def _solve_all(shape: GroupShape, pairs: PairHorizon, limits: _Limits, out: TeacherSolution) -> None:
    """Write the solutions of K pairs."""
    stages = pairs.push.shape[2]
    pair, other = np.array([0, 1]), np.array([1, 0])
    reference, path = np.zeros((2, stages + 1, 9)), np.zeros((2, stages + 1, 3))
    start, push, gradient = np.zeros((2, 3, 3)), np.zeros((2, stages, 3)), np.zeros((2, stages, 3, 3))
    low, high = np.full((2, 3), limits.low), np.full((2, stages, 3), limits.high)
    horizon = Horizon(start, reference, push, path, low, high, np.full(3, limits.slew_max))
    downwash = DownwashHorizon(push, pair, other, gradient)
    for q in range(out.inputs.shape[0]):
        start[:, 2], path[:, :, 2] = pairs.states[q], out.errors[q]
        push[:, :, 2], gradient[:, :, 2, 2] = pairs.push[q], pairs.gradient[q]
        found = solve_from(joint_problem(shape, pair, horizon, downwash), out.active_set[q], ITERATIONS)
        for v in range(2):
            out.inputs[q, v], out.errors[q, v] = found.inputs[0, v], found.states[:, 3 * v]
