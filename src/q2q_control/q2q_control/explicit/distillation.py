"""Distil the receding horizon into the explicit law: ask it at many places, fit what it answers.

Asked are random situations; then, since a law that is flown visits places of its own, those that the teacher
visits in encounters, and those that the law so found visits (Ross, Gordon, Bagnell, DAgger, 2011). Every
answer teaches twice: each vehicle of a pair is the first once.

Fit: where the gate is open, all weights together by L-BFGS on the mean squared error of the cut output. A
vehicle that no bound stops has nothing to learn: the linear law is its optimum.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from q2q_control.explicit.encounter_flight import Policy, fly, teacher_policy
from q2q_control.explicit.features import WIDTH, Features, look
from q2q_control.explicit.law import ExplicitLaw, evaluate
from q2q_control.explicit.situations import Situations, random_encounters, random_situations
from q2q_control.explicit.teacher import Teacher, answers, seen
from q2q_control.mpc.solver.chain_sweep import sweep_gains
from q2q_model.signals.values import Array

Single = NDArray[np.float32]

OPEN = 1e-3
"""A gate less open than this teaches nothing [-]."""
FEWEST = 100
"""With fewer lessons the network stays silent."""


@dataclass(frozen=True, slots=True)
class Syllabus:
    """Sizes of the training set and of the fit."""

    situations: int = 20000
    encounters: int = 250
    length: int = 100
    """Stages of an encounter."""
    layers: tuple[int, int] = (24, 16)
    iterations: int = 500


@dataclass(frozen=True, slots=True)
class Lessons:
    """Features of the law and the accelerations it should give [m/s^2], (K,)."""

    seen: Features
    said: Array


def distil(teacher: Teacher, syllabus: Syllabus, rng: np.random.Generator) -> ExplicitLaw:
    """Return the law that answers as the teacher does."""
    step = teacher.params.step
    law = _untaught(teacher, syllabus.layers, rng)
    asked = [random_situations(syllabus.situations, step, rng)]
    if not _meets_bounds(law, asked[0], teacher):
        return law
    for by_law in (False, True):
        shown = random_encounters(syllabus.encounters, syllabus.length, step, rng)
        policy = policy_of(law, teacher) if by_law else teacher_policy(teacher)
        asked.append(fly(shown, policy, teacher, lambda shape: _gusts(shape, rng)).visited)
        law = fitted(law, lessons(asked, teacher), syllabus.iterations)
    return law


def _meets_bounds(law: ExplicitLaw, asked: Situations, teacher: Teacher) -> bool:
    gates = look(seen(asked, teacher), law.gains, float(law.bounds[1])).gate
    return bool(np.count_nonzero(gates > OPEN) >= FEWEST)


def policy_of(law: ExplicitLaw, teacher: Teacher) -> Policy:
    """Return the law as a policy: each vehicle of a pair by itself."""

    def policy(asked: Situations) -> Array:
        pair = seen(asked, teacher)
        return np.stack([evaluate(law, pair), evaluate(law, pair.swapped())], axis=1)

    return policy


def lessons(asked: list[Situations], teacher: Teacher) -> Lessons:
    """Return what is to be learned of situations, each vehicle of a pair the first once."""
    gains, (low, high) = sweep_gains(teacher.chain), teacher.bounds
    looks, said = [], []
    for some in asked:
        pair, inputs = seen(some, teacher), answers(some, teacher).inputs
        looks += [look(pair, gains, high), look(pair.swapped(), gains, high)]
        said += [inputs[:, 0], inputs[:, 1]]
    whole = (np.concatenate([getattr(one, name) for one in looks]) for name in Features.__slots__)
    return Lessons(Features(*whole), np.clip(np.concatenate(said), low, high))


def fitted(law: ExplicitLaw, taught: Lessons, iterations: int) -> ExplicitLaw:
    """Return the law with weights fitted to lessons, from its own weights on."""
    on = taught.seen.gate > OPEN
    x, gate, base = (_single(getattr(taught.seen, name)[on]) for name in Features.__slots__)
    law = replace(
        law, mean=np.mean(x, axis=0, dtype=np.float64), scale=np.std(x, axis=0, dtype=np.float64) + 1e-6
    )
    data = (_single((x - law.mean) / law.scale), gate, base, _single(taught.said[on]))
    shapes = [part.shape for part in _weights(law)]
    start = np.concatenate([part.ravel() for part in _weights(law)])

    def loss(weights: Array) -> tuple[float, Array]:
        return _loss([_single(part) for part in _split(weights, shapes)], data, law.bounds)

    options = {"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": 30}
    found = minimize(loss, start, jac=True, method="L-BFGS-B", options=options)
    linear, first, second, last = _split(found.x, shapes)
    return replace(law, linear=linear, first=first, second=second, last=last)


def _single(values: Array) -> Single:
    """Return single precision: fits twice as quickly, and is what the vehicle has."""
    return np.asarray(values, dtype=np.float32)


def _untaught(teacher: Teacher, layers: tuple[int, int], rng: np.random.Generator) -> ExplicitLaw:
    """Return the linear law: the network says 0."""
    h1, h2 = layers
    return ExplicitLaw(
        gains=sweep_gains(teacher.chain),
        bounds=np.array(teacher.bounds),
        mean=np.zeros(WIDTH),
        scale=np.ones(WIDTH),
        linear=np.zeros(WIDTH + 1),
        first=rng.normal(size=(h1, WIDTH + 1)) / np.sqrt(WIDTH),
        second=rng.normal(size=(h2, h1 + 1)) / np.sqrt(h1),
        last=np.zeros(h2),
    )


def _gusts(shape: tuple[int, ...], rng: np.random.Generator) -> Array:
    """Return what throws one vehicle pair in ten off its path at a stage."""
    hit = rng.random((shape[0], 1, 1)) < 0.1
    return np.asarray(rng.normal(size=shape) * [0.004, 0.02, 0.0] * hit)


def _weights(law: ExplicitLaw) -> tuple[Array, Array, Array, Array]:
    return law.linear, law.first, law.second, law.last


def _split(flat: Array, shapes: list[tuple[int, ...]]) -> list[Array]:
    ends = np.cumsum([int(np.prod(shape)) for shape in shapes])
    return [part.reshape(shape) for part, shape in zip(np.split(flat, ends[:-1]), shapes, strict=True)]


def _loss(
    weights: list[Single], data: tuple[Single, Single, Single, Single], bounds: Array
) -> tuple[float, Array]:
    """Return the mean squared error of the cut output, and its gradient."""
    linear, first, second, last = weights
    z, gate, base, said = data
    low, high = _single(bounds)
    one = np.tanh(z @ first[:, :-1].T + first[:, -1])
    two = np.tanh(one @ second[:, :-1].T + second[:, -1])
    raw = base + gate * (z @ linear[:-1] + linear[-1] + two @ last)
    off = np.clip(raw, low, high) - said
    # beyond a bound only an error towards the inside counts: the cut hides the rest
    open_ = ((raw > low) | (off > 0.0)) & ((raw < high) | (off < 0.0))
    back = (2.0 / len(said)) * off * open_ * gate
    by_two = back[:, None] * last * (1.0 - two**2)
    by_one = (by_two @ second[:, :-1]) * (1.0 - one**2)
    gradient = [
        np.append(back @ z, back.sum()),
        np.column_stack([by_one.T @ z, by_one.sum(axis=0)]).ravel(),
        np.column_stack([by_two.T @ one, by_two.sum(axis=0)]).ravel(),
        back @ two,
    ]
    return float(np.mean(off**2, dtype=np.float64)), np.concatenate(gradient).astype(np.float64)
