"""Distil the receding horizon into the explicit law: ask it at many places, fit what it answers.

Questions: pairs whose second vehicle passes near the first along curved paths, both off their references, as
random as flights are; and, since a law that is flown visits places of its own, also those that it visits
(Ross, Gordon, Bagnell, DAgger, 2011). Each question is solved with the drafts linearised again until the
answer stands, so answers do not depend on how the horizon was reached.

Fit: the linear part by least squares on answers inside the bounds, then all weights together by L-BFGS on the
mean squared error of the cut output.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from q2q_control.explicit.features import WHEN, features
from q2q_control.explicit.law import ExplicitLaw
from q2q_control.mpc.chain import ChainWeights, chain
from q2q_control.mpc.draft_horizon import SlopeRule, Tracks, predict_drafts
from q2q_control.mpc.horizon import Horizon
from q2q_control.mpc.joint_problem import GroupShape, group_shape, joint_problem
from q2q_control.mpc.params import MpcParams
from q2q_control.mpc.riccati import solve
from q2q_model.interaction.model import InteractionModel
from q2q_model.signals import Array
from q2q_model.vehicle import GRAVITY, Vehicle

PAIR = np.array([0, 1])


@dataclass(frozen=True, slots=True)
class Questions:
    """Hold K situations of a pair."""

    errors: Array
    """e, e' of the first, then of the second, (K, 4)."""
    start: Array
    """Reference position, velocity, acceleration of both at the start [SI], (K, 2, 9)."""
    jerk: Array
    """Of both references, constant [m/s^3], (K, 2, 3)."""

    def positions(self, ahead: Array) -> Array:
        """Return the reference positions at times `ahead` (M,) [s], (K, 2, M, 3)."""
        t = ahead[:, None]
        pos, vel, acc = (self.start[:, :, None, k : k + 3] for k in (0, 3, 6))
        return np.asarray(pos + vel * t + acc * t**2 / 2.0 + self.jerk[:, :, None] * t**3 / 6.0)


@dataclass(frozen=True, slots=True)
class Teacher:
    """Hold what answers the questions."""

    params: MpcParams
    vehicle: Vehicle
    model: InteractionModel
    thrust_max: float
    """[N]"""
    rounds: int = 4
    """Linearisations for each answer."""

    @property
    def bounds(self) -> tuple[float, float]:
        """Return the least and largest vertical acceleration command of a level vehicle [m/s^2]."""
        return -0.95 * GRAVITY, self.thrust_max / self.vehicle.mass - GRAVITY


def random_questions(count: int, rng: np.random.Generator) -> Questions:
    """Return situations of a second vehicle that passes 0.25 to 1 m above or below the first."""
    start, jerk = np.zeros((count, 2, 9)), np.zeros((count, 2, 3))
    side = rng.normal(size=(count, 2)) * [[0.12, 0.35]]
    heading = rng.uniform(0.0, 2.0 * np.pi, count)
    turn = np.stack([np.cos(heading), -np.sin(heading), np.sin(heading), np.cos(heading)], -1).reshape(
        -1, 2, 2
    )
    start[:, 1, :2] = np.einsum("kab,kb->ka", turn, side)
    start[:, 1, 2] = rng.uniform(0.25, 1.0, count) * rng.choice([-1.0, 1.0], count)
    speed = rng.normal(size=(count, 2)) * [[0.03, 0.25]] * rng.choice([0.1, 0.3, 1.0], (count, 1))
    start[:, 1, 3:5] = np.einsum("kab,kb->ka", turn, speed)
    start[:, 1, 6:8] = np.einsum("kab,kb->ka", turn, rng.normal(size=(count, 2)) * [[0.005, 0.04]])
    jerk[:, 1, :2] = rng.normal(size=(count, 2)) * 0.02
    spread = rng.choice([0.2, 1.0], (count, 1))
    errors = rng.normal(size=(count, 4)) * [0.04, 0.06, 0.04, 0.06] * spread
    return Questions(errors, start, jerk)


def answers(questions: Questions, teacher: Teacher) -> Array:
    """Return the first vehicle's command [m/s^2] for each question, (K,)."""
    params = teacher.params
    ahead = np.linspace(0.0, params.horizon, params.steps + 1)
    shape = _shape(teacher)
    low, high = teacher.bounds
    paths = questions.positions(ahead)  # (K, 2, N + 1, 3)
    level = np.tile([0.0, 0.0, 1.0], (2, params.steps, 1))
    out = np.empty(len(paths))
    for k, reference in enumerate(paths):
        path = reference.copy()
        start = np.zeros((2, 3, 3))
        start[:, 2, 0] = reference[:, 0, 2] + questions.errors[k, 0::2]
        start[:, 2, 1] = questions.errors[k, 1::2]
        whole = np.concatenate([reference, np.zeros((2, params.steps + 1, 6))], axis=-1)
        pattern = None
        for _ in range(teacher.rounds):
            tracks = Tracks(ahead, np.ascontiguousarray(path.transpose(1, 0, 2)), level, np.ones(2), 0)
            drafts = predict_drafts(teacher.model, tracks, SlopeRule((2,), params.slope_max))
            bound = np.array([[0.0, 0.0, high]] * 2)
            asked = Horizon(start, whole, drafts.eta, path, np.minimum(bound, low), bound, np.full(3, np.inf))
            found = solve(joint_problem(shape, PAIR, asked, drafts), pattern, 60)
            pattern = found.pattern
            path[:, :, 2] = found.states[:, 0::3].T
        out[k] = found.inputs[0, 0]
    return out


def distil(questions: Questions, said: Array, teacher: Teacher, layers: tuple[int, int]) -> ExplicitLaw:
    """Return the law that answers as the teacher `said` (K,), with hidden layers of the given sizes."""
    x = features(questions.errors, questions.positions(WHEN), teacher.model)
    law = _first_guess(x, said, teacher, layers)
    sizes = [law.linear.size, law.first.size, law.second.size, law.last.size]
    start = np.concatenate([law.linear, law.first.ravel(), law.second.ravel(), law.last])
    z = (x - law.mean) / law.scale

    def loss(weights: Array) -> tuple[float, Array]:
        return _loss(weights, sizes, (x, z, said), law)

    found = minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": 1500, "maxfun": 3000})
    linear, first, second, last = np.split(found.x, np.cumsum(sizes)[:-1])
    return ExplicitLaw(
        mean=law.mean,
        scale=law.scale,
        linear=linear,
        first=first.reshape(law.first.shape),
        second=second.reshape(law.second.shape),
        last=last,
        bounds=law.bounds,
    )


def _shape(teacher: Teacher) -> GroupShape:
    params = teacher.params
    up = chain(teacher.vehicle.thrust_lag, params.step, ChainWeights(params.bandwidth_z, params.jerk))
    shape = group_shape(2, (2,), (up, up, up), params.steps)
    return shape._replace(terminal=params.terminal * shape.terminal)


def _first_guess(x: Array, said: Array, teacher: Teacher, layers: tuple[int, int]) -> ExplicitLaw:
    rng = np.random.default_rng(0)
    low, high = teacher.bounds
    h1, h2 = layers
    inside = (said > low + 1e-6) & (said < high - 1e-6)
    wide = np.column_stack([x, np.ones(len(x))])
    linear = np.asarray(np.linalg.lstsq(wide[inside], said[inside], rcond=None)[0], dtype=np.float64)
    first = rng.normal(size=(h1, x.shape[1] + 1)) / np.sqrt(x.shape[1])
    second = rng.normal(size=(h2, h1 + 1)) / np.sqrt(h1)
    bounds = np.array([low, high])
    mean: Array = np.mean(x, axis=0)
    scale: Array = np.std(x, axis=0) + 1e-6
    return ExplicitLaw(mean, scale, linear, first, second, np.zeros(h2 + 1), bounds)


def _loss(
    weights: Array, sizes: list[int], data: tuple[Array, Array, Array], law: ExplicitLaw
) -> tuple[float, Array]:
    """Return the mean squared error of the cut output, and its gradient."""
    x, z, said = data
    linear, first, second, last = np.split(weights, np.cumsum(sizes)[:-1])
    first, second = first.reshape(law.first.shape), second.reshape(law.second.shape)
    one = np.tanh(z @ first[:, :-1].T + first[:, -1])
    two = np.tanh(one @ second[:, :-1].T + second[:, -1])
    raw = x @ linear[:-1] + linear[-1] + two @ last[:-1] + last[-1]
    off = np.clip(raw, law.bounds[0], law.bounds[1]) - said
    # beyond a bound only an error towards the inside counts: the cut hides the rest
    open_ = ((raw > law.bounds[0]) | (off > 0.0)) & ((raw < law.bounds[1]) | (off < 0.0))
    back = 2.0 * off * open_ / len(said)
    by_two = back[:, None] * last[:-1] * (1.0 - two**2)
    by_one = (by_two @ second[:, :-1]) * (1.0 - one**2)
    gradient = [
        np.append(back @ x, back.sum()),
        np.column_stack([by_one.T @ z, by_one.sum(axis=0)]).ravel(),
        np.column_stack([by_two.T @ one, by_two.sum(axis=0)]).ravel(),
        np.append(back @ two, back.sum()),
    ]
    return float((off**2).mean()), np.concatenate(gradient)
