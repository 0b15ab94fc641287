"""Distillation of the receding horizon into the explicit law: dataset aggregation and fit.

The training set starts with random situations. Since a flown law visits situations of its own, those that the
teacher visits in encounters are added, then those that the fitted law visits (Ross, Gordon, Bagnell, DAgger,
2011). Every solution is used twice, with either vehicle of the pair as the first.

Fit: where the gate is open, all weights together by L-BFGS on the mean squared error of the clipped output. A
vehicle that meets no bound contributes nothing: the linear law is its optimum.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from q2q_control.explicit_mpc.encounter_flight import ControlPolicy, fly_encounters, teacher_policy
from q2q_control.explicit_mpc.explicit_law import ExplicitLaw, evaluate
from q2q_control.explicit_mpc.features import WIDTH, Features, features
from q2q_control.explicit_mpc.situations import Situations, random_encounters, random_situations
from q2q_control.explicit_mpc.teacher import Teacher, pair_horizon, solve_situations
from q2q_control.mpc.solver.axis_sweep import gains_table, sweep_gains
from q2q_model.signals.values import Array

Single = NDArray[np.float32]

GATE_MIN = 1e-3
"""Minimum gate of a sample that is fitted [-]."""
FEWEST_SAMPLES = 100
"""With fewer samples the network is not fitted: its output is 0."""


@dataclass(frozen=True, slots=True)
class DistillationParams:
    """Sizes of the training set, the network and the fit."""

    situations: int = 20000
    encounters: int = 250
    length: int = 100
    """Stages of an encounter."""
    layers: tuple[int, int] = (24, 16)
    iterations: int = 500


@dataclass(frozen=True, slots=True)
class TrainingSet:
    """K samples of the teacher."""

    features: Features
    commands: Array
    """Clipped accelerations [m/s^2], (K,)."""


def distil(teacher: Teacher, params: DistillationParams, rng: np.random.Generator) -> ExplicitLaw:
    """Return the law that reproduces the teacher's commands."""
    step = teacher.params.step
    law = _initial_law(teacher, params.layers, rng)
    situations = [random_situations(params.situations, step, rng)]
    if not _meets_bounds(law, situations[0], teacher):
        return law
    for by_law in (False, True):
        encounters = random_encounters(params.encounters, params.length, step, rng)
        policy = control_policy(law, teacher) if by_law else teacher_policy(teacher)
        situations.append(
            fly_encounters(encounters, policy, teacher, lambda shape: _gusts(shape, rng)).visited
        )
        law = fit_weights(law, training_set(situations, teacher), params.iterations)
    return law


def _meets_bounds(law: ExplicitLaw, situations: Situations, teacher: Teacher) -> bool:
    gates = features(pair_horizon(situations, teacher), law.altitude_gains, float(law.bounds[1])).gate
    return bool(np.count_nonzero(gates > GATE_MIN) >= FEWEST_SAMPLES)


def control_policy(law: ExplicitLaw, teacher: Teacher) -> ControlPolicy:
    """Return the law as a control policy: each vehicle of a pair by itself."""

    def policy(situations: Situations) -> Array:
        pair = pair_horizon(situations, teacher)
        return np.stack([evaluate(law, pair), evaluate(law, pair.swapped())], axis=1)

    return policy


def training_set(situations: list[Situations], teacher: Teacher) -> TrainingSet:
    """Return the samples of situations, with either vehicle of a pair as the first."""
    gains, (low, high) = sweep_gains(teacher.altitude_model), teacher.bounds
    samples, commands = [], []
    for some in situations:
        pair, inputs = pair_horizon(some, teacher), solve_situations(some, teacher).inputs
        samples += [features(pair, gains, high), features(pair.swapped(), gains, high)]
        commands += [inputs[:, 0], inputs[:, 1]]
    whole = (np.concatenate([getattr(one, name) for one in samples]) for name in Features.__slots__)
    return TrainingSet(Features(*whole), np.clip(np.concatenate(commands), low, high))


def fit_weights(law: ExplicitLaw, samples: TrainingSet, iterations: int) -> ExplicitLaw:
    """Return the law with weights fitted to samples, starting at its own weights."""
    on = samples.features.gate > GATE_MIN
    x, gate, base = (_single(getattr(samples.features, name)[on]) for name in Features.__slots__)
    law = replace(
        law, mean=np.mean(x, axis=0, dtype=np.float64), scale=np.std(x, axis=0, dtype=np.float64) + 1e-6
    )
    data = _FitData(_single((x - law.mean) / law.scale), gate, base, _single(samples.commands[on]))
    shapes = [part.shape for part in _weights(law)]
    start = np.concatenate([part.ravel() for part in _weights(law)])

    def loss(weights: Array) -> tuple[float, Array]:
        return _loss([_single(part) for part in _split(weights, shapes)], data, law.bounds)

    options = {"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": 30}
    found = minimize(loss, start, jac=True, method="L-BFGS-B", options=options)
    linear, first, second, last = _split(found.x, shapes)
    return replace(law, linear=linear, first=first, second=second, last=last)


def _single(values: Array) -> Single:
    """Return single precision: it fits twice as fast, and is that of the vehicle's processor."""
    return np.asarray(values, dtype=np.float32)


def _initial_law(teacher: Teacher, layers: tuple[int, int], rng: np.random.Generator) -> ExplicitLaw:
    """Return the linear law: the network's output is 0."""
    h1, h2 = layers
    return ExplicitLaw(
        gains=gains_table(sweep_gains(teacher.altitude_model)),
        bounds=np.array(teacher.bounds),
        mean=np.zeros(WIDTH),
        scale=np.ones(WIDTH),
        linear=np.zeros(WIDTH + 1),
        first=rng.normal(size=(h1, WIDTH + 1)) / np.sqrt(WIDTH),
        second=rng.normal(size=(h2, h1 + 1)) / np.sqrt(h1),
        last=np.zeros(h2),
    )


def _gusts(shape: tuple[int, ...], rng: np.random.Generator) -> Array:
    """Return disturbances that hit one vehicle pair in ten at a stage."""
    hit = rng.random((shape[0], 1, 1)) < 0.1
    return np.asarray(rng.normal(size=shape) * [0.004, 0.02, 0.0] * hit)


def _weights(law: ExplicitLaw) -> tuple[Array, Array, Array, Array]:
    return law.linear, law.first, law.second, law.last


def _split(flat: Array, shapes: list[tuple[int, ...]]) -> list[Array]:
    ends = np.cumsum([int(np.prod(shape)) for shape in shapes])
    return [part.reshape(shape) for part, shape in zip(np.split(flat, ends[:-1]), shapes, strict=True)]


@dataclass(frozen=True, slots=True)
class _FitData:
    """Samples whose gate is open, (K,), in single precision."""

    z: Single
    """Scaled features, (K, WIDTH)."""
    gate: Single
    base: Single
    command: Single


def _loss(weights: list[Single], data: _FitData, bounds: Array) -> tuple[float, Array]:
    """Return the mean squared error of the clipped output, and its gradient."""
    linear, first, second, last = weights
    z, gate = data.z, data.gate
    low, high = _single(bounds)
    one = np.tanh(z @ first[:, :-1].T + first[:, -1])
    two = np.tanh(one @ second[:, :-1].T + second[:, -1])
    raw = data.base + gate * (z @ linear[:-1] + linear[-1] + two @ last)
    off = np.clip(raw, low, high) - data.command
    # beyond a bound only an error towards the inside counts: clipping hides the rest
    open_ = ((raw > low) | (off > 0.0)) & ((raw < high) | (off < 0.0))
    back = (2.0 / len(data.command)) * off * open_ * gate
    by_two = back[:, None] * last * (1.0 - two**2)
    by_one = (by_two @ second[:, :-1]) * (1.0 - one**2)
    gradient = [
        np.append(back @ z, back.sum()),
        np.column_stack([by_one.T @ z, by_one.sum(axis=0)]).ravel(),
        np.column_stack([by_two.T @ one, by_two.sum(axis=0)]).ravel(),
        back @ two,
    ]
    return float(np.mean(off**2, dtype=np.float64)), np.concatenate(gradient).astype(np.float64)
