"""Explicit law: the unbounded optimum, corrected by a small network where a bound lies ahead.

    u = clip(base + gate (w0 . z + b0 + W3 tanh(W2 tanh(W1 z + b1) + b2)), low, high),  z = (x - mean) / scale

base, gate and x are those of `features`; u is the first vehicle's vertical acceleration command, its
reference's included. Where no bound is met the gate is 0 and u the MPC's own command.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_control.explicit_mpc.features import STAGES, WIDTH, PairHorizon, features, write_features
from q2q_control.mpc.solver.axis_sweep import AxisGains, gains_of_table
from q2q_model.compiled import FAST, compiled
from q2q_model.signals.values import Array

GAINS = (13, 3)
"""Shape of AxisGains as a table: six vectors, the scalars quu and effort, A, P."""


@dataclass(frozen=True, slots=True)
class ExplicitLaw:
    """Gains of the altitude axis and network weights of the law; h1, h2 are the layers' sizes."""

    gains: Array
    """AxisGains of the altitude axis as a table, (13, 3)."""
    bounds: Array
    """low, high [m/s^2], (2,)."""
    mean: Array
    """(x,)"""
    scale: Array
    """(x,)"""
    linear: Array
    """w0 and b0, (x + 1,)."""
    first: Array
    """W1 and b1, (h1, x + 1)."""
    second: Array
    """W2 and b2, (h2, h1 + 1)."""
    last: Array
    """W3, (h2,)."""

    def __post_init__(self) -> None:
        """Check that the layers fit together and are finite."""
        x, h1, h2 = WIDTH, self.first.shape[0], self.second.shape[0]
        shapes = tuple(getattr(self, name).shape for name in self.__slots__)
        if shapes != (GAINS, (2,), (x,), (x,), (x + 1,), (h1, x + 1), (h2, h1 + 1), (h2,)):
            raise ValueError(f"layers of shapes {shapes} do not fit {x} inputs")
        if not all(np.isfinite(getattr(self, name)).all() for name in self.__slots__):
            raise ValueError("a weight of the explicit law is not a number")

    @property
    def altitude_gains(self) -> AxisGains:
        """Return the gains of the altitude axis by name."""
        return gains_of_table(np.ascontiguousarray(self.gains))


class LawWeights(NamedTuple):
    """Law as its kernels take it."""

    gains: AxisGains
    low: float
    """[m/s^2]"""
    high: float
    """[m/s^2]"""
    mean: Array
    """(x,)"""
    inverse_scale: Array
    """(x,)"""
    linear: Array
    """(x + 1,)"""
    first: Array
    """(h1, x + 1)"""
    second: Array
    """(h2, h1 + 1)"""
    last: Array
    """(h2,)"""


class LawWorkspace(NamedTuple):
    """Arrays that one evaluation needs."""

    unbounded: Array
    """(2, STAGES)"""
    x: Array
    """(WIDTH,)"""
    one: Array
    """(h1,)"""
    two: Array
    """(h2,)"""


def weights_of(law: ExplicitLaw) -> LawWeights:
    """Return the law's numbers for its kernels."""
    return LawWeights(
        law.altitude_gains,
        float(law.bounds[0]),
        float(law.bounds[1]),
        law.mean,
        1.0 / law.scale,
        law.linear,
        law.first,
        law.second,
        law.last,
    )


def workspace_of(law: ExplicitLaw) -> LawWorkspace:
    """Return uninitialised arrays for one evaluation."""
    return LawWorkspace(
        np.empty((2, STAGES)), np.empty(WIDTH), np.empty(len(law.first)), np.empty(len(law.second))
    )


def evaluate(law: ExplicitLaw, pair: PairHorizon) -> Array:
    """Return u of the first vehicles of many pairs [m/s^2], (...,)."""
    seen = features(pair, law.altitude_gains, float(law.bounds[1]))
    raw = seen.base + seen.gate * network_output(law, (seen.x - law.mean) / law.scale)
    return np.asarray(np.clip(raw, law.bounds[0], law.bounds[1]))


def network_output(law: ExplicitLaw, z: Array) -> Array:
    """Return the network's output [m/s^2], (...,), of z (..., WIDTH)."""
    one = np.tanh(z @ law.first[:, :-1].T + law.first[:, -1])
    two = np.tanh(one @ law.second[:, :-1].T + law.second[:, -1])
    return np.asarray(z @ law.linear[:-1] + law.linear[-1] + two @ law.last)


@compiled(**FAST)
def evaluate_all(law: LawWeights, pairs: PairHorizon, work: LawWorkspace) -> Array:
    """Return u [m/s^2] of K pairs, (K,)."""
    u = np.empty(pairs.states.shape[0])
    for k in range(u.size):
        u[k] = evaluate_one(law, PairHorizon(pairs.states[k], pairs.push[k], pairs.gradient[k]), work)
    return u


@compiled(**FAST)
def evaluate_one(law: LawWeights, pair: PairHorizon, work: LawWorkspace) -> float:
    """Return u [m/s^2] of one pair."""
    base, gate = write_features(pair, law.gains, law.high, work.unbounded, work.x)
    if gate > 0.0:
        base += gate * _network(law, work)
    return float(min(max(base, law.low), law.high))


@compiled(**FAST)
def _network(law: LawWeights, work: LawWorkspace) -> float:
    """Return the network's output; work.x becomes z."""
    x, one, two = work.x, work.one, work.two
    for i in range(WIDTH):
        x[i] = (x[i] - law.mean[i]) * law.inverse_scale[i]
    for a in range(one.size):
        one[a] = _tanh(_dot(law.first[a, :WIDTH], x) + law.first[a, WIDTH])
    for b in range(two.size):
        two[b] = _tanh(_dot(law.second[b, : one.size], one) + law.second[b, one.size])
    return float(_dot(law.linear[:WIDTH], x) + law.linear[WIDTH] + _dot(law.last, two))


@compiled(**FAST)
def _tanh(x: float) -> float:
    """Return tanh x: by exp it is twice as fast."""
    return 1.0 - 2.0 / (math.exp(2.0 * x) + 1.0)


@compiled(**FAST)
def _dot(left: Array, right: Array) -> float:
    """Return the scalar product: vectorised in a function of its own, three times as fast."""
    total = 0.0
    for i in range(left.size):
        total += left[i] * right[i]
    return total
