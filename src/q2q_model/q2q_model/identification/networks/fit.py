"""Fit of the paper's two networks to altitudes, with Adam and with faster methods for the same loss (16).

    minimise  loss(theta) + decay |theta|^2        loss: q2q_model.identification.networks.trajectory_loss

`ridge_start` draws the hidden layer at random and solves for the output layer at the measured distances, a
linear system because eta and the altitude are linear in it (Huang, Zhu, Siew, Extreme learning machine,
2006). `fit_networks` continues from there with L-BFGS (Liu, Nocedal, 1989) and the exact gradient. `adam` is
the paper's optimiser, step 1e-4, with the same gradient. Weight decay regularises f where there are no data.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize

from q2q_model.downwash.envelope_network import HIDDEN, EnvelopeNetwork
from q2q_model.geometry.zone import Cylinder
from q2q_model.identification.networks.gradient import evaluate, output_features, pack, unpack
from q2q_model.identification.networks.trajectory_loss import (
    DivergingModelError,
    FlightTerms,
    trajectory_loss,
)
from q2q_model.signals.values import Array

FORBIDDEN = 1e6
"""Loss of networks without a consistent altitude [m^2]."""
STEEP = 3.0
"""Standard deviation of the random hidden weights [1/m]: a unit saturates within a third of a metre."""
BETA1, BETA2, TINY = 0.9, 0.999, 1e-8
"""Adam's default parameters (Kingma, Ba, 2015)."""
RATE = 1e-4
"""Adam's step size, Table 4."""


@dataclass(frozen=True, slots=True)
class NetworkFitParams:
    """Parameters of the network fit."""

    envelope: Cylinder = field(default_factory=Cylinder)
    """eps and d of (15)."""
    decay: float = 3e-6
    """Weight of |theta|^2 in the loss [m^2]."""
    iterations: int = 150
    seed: int = 0


def fit_networks(terms: Sequence[FlightTerms], params: NetworkFitParams | None = None) -> EnvelopeNetwork:
    """Return networks fitted to flights by ridge regression and L-BFGS."""
    given = params or NetworkFitParams()
    zone = given.envelope
    near: tuple[Array, ...] | None = None

    def loss(theta: Array) -> tuple[float, Array]:
        nonlocal near
        try:
            value = trajectory_loss(unpack(theta, zone.eps, zone.d), terms, near)
        except DivergingModelError:  # the line search stepped too far
            return FORBIDDEN, np.zeros_like(theta)
        near = value.etas
        return value.loss + given.decay * float(theta @ theta), value.gradient + 2.0 * given.decay * theta

    start = pack(ridge_start(terms, given))
    found = minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": given.iterations})
    return unpack(found.x, zone.eps, zone.d)


def ridge_start(terms: Sequence[FlightTerms], params: NetworkFitParams) -> EnvelopeNetwork:
    """Return networks with random hidden layers and the optimal output layers."""
    zone = params.envelope
    theta = random_weights(np.random.default_rng(params.seed))
    model = unpack(theta, zone.eps, zone.d)
    outputs = 2 * (HIDDEN + 1)
    normal, right = params.decay * np.eye(outputs), np.zeros(outputs)
    for one in terms:
        at = evaluate(model, one.across.ravel(), one.dz.ravel())
        features = output_features(at, one.across.size).reshape(*one.across.shape, outputs)  # (S, p, 82)
        for vehicle in range(one.free.shape[1]):
            summed = features[:, one.i == vehicle].sum(axis=1)
            normal += summed.T @ one.G @ summed / (one.ticks * len(terms))
            right += summed.T @ one.q[:, vehicle] / (one.ticks * len(terms))
    best = np.linalg.solve(normal, right).astype(np.float64)
    return unpack(_with_outputs(theta, best), zone.eps, zone.d)


def adam(terms: Sequence[FlightTerms], start: EnvelopeNetwork) -> Iterator[tuple[EnvelopeNetwork, float]]:
    """Yield the networks before each of Adam's steps, with their loss (16), endlessly."""
    theta, first, second = pack(start), np.zeros(1), np.zeros(1)
    step, near, before = 0, None, None
    while True:
        model = unpack(theta, start.eps, start.d)
        value = trajectory_loss(model, terms, near)
        near = value.etas if before is None else _ahead(before, value.etas)
        before = value.etas
        yield model, value.loss
        step += 1
        first = BETA1 * first + (1.0 - BETA1) * value.gradient
        second = BETA2 * second + (1.0 - BETA2) * value.gradient**2
        mean, scale = first / (1.0 - BETA1**step), np.sqrt(second / (1.0 - BETA2**step))
        theta = theta - RATE * mean / (scale + TINY)


def _ahead(before: Sequence[Array], now: Sequence[Array]) -> tuple[Array, ...]:
    """Return a linear extrapolation of the last two solutions, as the start of the next fixed point."""
    return tuple(2.0 * new - old for old, new in zip(before, now, strict=True))


def random_weights(rng: np.random.Generator) -> Array:
    """Return theta with random hidden layers and zero output layers, (322,)."""
    parts = [
        (STEEP * rng.standard_normal(2 * HIDDEN), rng.standard_normal(HIDDEN), np.zeros(HIDDEN + 1))
        for _ in range(2)
    ]
    return np.concatenate([np.concatenate(part) for part in parts])


def _with_outputs(theta: Array, outputs: Array) -> Array:
    lower, upper = np.split(theta.copy(), 2)
    for part, values in zip((lower, upper), np.split(outputs, 2), strict=True):
        part[3 * HIDDEN :] = values
    return np.concatenate((lower, upper))
