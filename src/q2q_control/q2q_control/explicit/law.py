"""Evaluate the explicit law: the unbounded optimum, bent by a small network where a bound lies ahead.

    u = clip(base + gate (w0 . z + b0 + W3 tanh(W2 tanh(W1 z + b1) + b2)), low, high),  z = (x - mean) / scale

base, gate and x are those of q2q_control.explicit.features; u is the first vehicle's vertical acceleration
command, less its reference's acceleration. Where no bound is met the gate is 0 and u the MPC's own answer.
"""

import json
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.explicit.features import STAGES, WIDTH, PairHorizon, look, look_one
from q2q_model.compiled import FAST, compiled
from q2q_model.signals.values import Array

FORMAT = 2
"""Version of the written form."""
GAINS = (13, 3)
"""Shape of `sweep_gains`."""
_OF_GAINS = GAINS[0] * GAINS[1]


@dataclass(frozen=True, slots=True)
class ExplicitLaw:
    """Linear chain and network weights of the law; h1, h2 are the layers' sizes."""

    gains: Array
    """Of the chain (q2q_control.mpc.solver.chain_sweep.sweep_gains), (13, 3)."""
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
        """Check that the layers fit together and are numbers."""
        x, h1, h2 = WIDTH, self.first.shape[0], self.second.shape[0]
        shapes = tuple(getattr(self, name).shape for name in self.__slots__)
        if shapes != (GAINS, (2,), (x,), (x,), (x + 1,), (h1, x + 1), (h2, h1 + 1), (h2,)):
            raise ValueError(f"layers of shapes {shapes} do not fit {x} inputs")
        if not all(np.isfinite(getattr(self, name)).all() for name in self.__slots__):
            raise ValueError("a weight of the explicit law is not a number")


def packed(law: ExplicitLaw) -> tuple[Array, NDArray[np.int64]]:
    """Return all weights in one row, as compiled code reads them, and the sizes h1, h2."""
    parts = (law.gains, law.bounds, law.mean, 1.0 / law.scale, law.linear, law.first, law.second, law.last)
    sizes = np.array([law.first.shape[0], law.second.shape[0]])
    return np.concatenate([part.ravel() for part in parts]), sizes


def scratch_of(law: ExplicitLaw) -> Array:
    """Return the room that one evaluation needs."""
    return np.empty(2 * STAGES + WIDTH + law.first.shape[0] + law.second.shape[0])


def evaluate(law: ExplicitLaw, pair: PairHorizon) -> Array:
    """Return u of the first vehicles [m/s^2], (...,): the plain form."""
    seen = look(pair, law.gains, float(law.bounds[1]))
    raw = seen.base + seen.gate * network(law, (seen.x - law.mean) / law.scale)
    return np.asarray(np.clip(raw, law.bounds[0], law.bounds[1]))


def network(law: ExplicitLaw, z: Array) -> Array:
    """Return what the network adds where the gate is open [m/s^2], (...,), of z (..., WIDTH)."""
    one = np.tanh(z @ law.first[:, :-1].T + law.first[:, -1])
    two = np.tanh(one @ law.second[:, :-1].T + law.second[:, -1])
    return np.asarray(z @ law.linear[:-1] + law.linear[-1] + two @ law.last)


@compiled(**FAST)
def evaluate_one(
    weights: Array, sizes: NDArray[np.int64], pair: tuple[Array, Array, Array], scratch: Array
) -> float:
    """Return u [m/s^2] of one pair: `weights`, `sizes` of `packed`, a PairHorizon's arrays, `scratch_of`."""
    gains = weights[:_OF_GAINS].reshape(GAINS)
    low, high = weights[_OF_GAINS], weights[_OF_GAINS + 1]
    place = 2 * STAGES
    x = scratch[place : place + WIDTH]
    base, gate = look_one(pair, gains, high, scratch[:place].reshape((2, STAGES)), x)
    if gate > 0.0:
        base += gate * _network(weights[_OF_GAINS + 2 :], sizes, x, scratch[place + WIDTH :])
    return float(min(max(base, low), high))


@compiled(**FAST)
def _network(weights: Array, sizes: NDArray[np.int64], x: Array, scratch: Array) -> float:
    """Return the network's answer; x becomes z."""
    h1, h2 = sizes[0], sizes[1]
    place = 2 * WIDTH
    for i in range(WIDTH):
        x[i] = (x[i] - weights[i]) * weights[WIDTH + i]
    total = _dot(weights[place : place + WIDTH], x) + weights[place + WIDTH]
    place += WIDTH + 1
    for a in range(h1):
        scratch[a] = _bent(_dot(weights[place : place + WIDTH], x) + weights[place + WIDTH])
        place += WIDTH + 1
    one = scratch[:h1]
    for b in range(h2):
        scratch[h1 + b] = _bent(_dot(weights[place : place + h1], one) + weights[place + h1])
        place += h1 + 1
    return float(total + _dot(weights[place : place + h2], scratch[h1 : h1 + h2]))


@compiled(**FAST)
def _bent(inside: float) -> float:
    """Return tanh: by exp it is twice as quick."""
    return 1.0 - 2.0 / (math.exp(2.0 * inside) + 1.0)


@compiled(**FAST)
def _dot(left: Array, right: Array) -> float:
    """Return the product of two rows: in a function of its own it is vectorised, three times as quick."""
    total = 0.0
    for i in range(left.size):
        total += left[i] * right[i]
    return total


@compiled(**FAST)
def evaluate_all(
    weights: Array,
    sizes: NDArray[np.int64],
    pairs: tuple[Array, Array, Array],
    scratch: Array,
) -> Array:
    """Return u [m/s^2] of K pairs (K,): as `evaluate_one`, of a PairHorizon's arrays with K rows."""
    states, push, slope = pairs
    found = np.empty(states.shape[0])
    for k in range(found.size):
        found[k] = evaluate_one(weights, sizes, (states[k], push[k], slope[k]), scratch)
    return found


def to_text(law: ExplicitLaw) -> str:
    """Return the law as JSON text."""
    return json.dumps({"format": FORMAT} | {name: getattr(law, name).tolist() for name in law.__slots__})


def from_text(text: str) -> ExplicitLaw:
    """Return the law of JSON text.

    Raises:
        ValueError: it is no law, of another format, or for other inputs.
    """
    try:
        found = json.loads(text)
        version = found.pop("format")
        law = ExplicitLaw(**{name: np.array(part, dtype=np.float64) for name, part in found.items()})
    except (json.JSONDecodeError, KeyError, TypeError, AttributeError, IndexError, ValueError) as error:
        raise ValueError(f"no explicit law of format {FORMAT}: {error}") from error
    if version != FORMAT:
        raise ValueError(f"an explicit law of format {version}: {FORMAT} is read here")
    return law
