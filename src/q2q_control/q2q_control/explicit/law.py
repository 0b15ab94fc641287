"""Evaluate the explicit law: a linear law, bent by a small network, cut at the bounds.

    u = clip(w0 . x + b0 + W3 tanh(W2 tanh(W1 z + b1) + b2),  low, high),   z = (x - mean) / scale

x is that of q2q_control.explicit.features, u the first vehicle's vertical acceleration command. The linear
part is what the horizon does where no bound is near; the network learns the rest.
"""

import json
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from q2q_control.explicit.features import WIDTH
from q2q_model.compiled import compiled
from q2q_model.signals import Array

FORMAT = 1
"""Version of the written form."""


@dataclass(frozen=True, slots=True)
class ExplicitLaw:
    """Hold the weights; h1, h2 are the layers' sizes."""

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
    """W3 and its offset, (h2 + 1,)."""
    bounds: Array
    """low, high [m/s^2], (2,)."""

    def __post_init__(self) -> None:
        """Check that the layers fit together and are numbers."""
        x, h1, h2 = self.mean.size, self.first.shape[0], self.second.shape[0]
        shapes = (self.scale.shape, self.linear.shape, self.first.shape, self.second.shape, self.last.shape)
        if shapes != ((x,), (x + 1,), (h1, x + 1), (h2, h1 + 1), (h2 + 1,)):
            raise ValueError(f"layers of shapes {shapes} do not fit {x} inputs")
        for part in (self.mean, self.scale, self.linear, self.first, self.second, self.last, self.bounds):
            if not np.isfinite(part).all():
                raise ValueError("a weight of the explicit law is not a number")


def packed(law: ExplicitLaw) -> tuple[Array, NDArray[np.int64]]:
    """Return all weights in one row, as compiled code and C read them, and the sizes x, h1, h2."""
    parts = (law.mean, 1.0 / law.scale, law.linear, law.first, law.second, law.last, law.bounds)
    sizes = np.array([law.mean.size, law.first.shape[0], law.second.shape[0]])
    return np.concatenate([part.ravel() for part in parts]), sizes


def evaluate(law: ExplicitLaw, x: Array) -> Array:
    """Return u [m/s^2], (...,), of x (..., WIDTH): the plain form."""
    z = (x - law.mean) / law.scale
    one = np.tanh(z @ law.first[:, :-1].T + law.first[:, -1])
    two = np.tanh(one @ law.second[:, :-1].T + law.second[:, -1])
    bent = x @ law.linear[:-1] + law.linear[-1] + two @ law.last[:-1] + law.last[-1]
    return np.asarray(np.clip(bent, law.bounds[0], law.bounds[1]))


def _evaluate_one_py(weights: Array, sizes: NDArray[np.int64], x: Array, scratch: Array) -> float:
    n, h1, h2 = sizes[0], sizes[1], sizes[2]
    place = 2 * n
    total = weights[place + n]
    for i in range(n):
        total += weights[place + i] * x[i]
        scratch[i] = (x[i] - weights[i]) * weights[n + i]
    place += n + 1
    for a in range(h1):
        inside = weights[place + n]
        for i in range(n):
            inside += weights[place + i] * scratch[i]
        scratch[n + a] = np.tanh(inside)
        place += n + 1
    for b in range(h2):
        inside = weights[place + h1]
        for a in range(h1):
            inside += weights[place + a] * scratch[n + a]
        scratch[n + h1 + b] = np.tanh(inside)
        place += h1 + 1
    for b in range(h2):
        total += weights[place + b] * scratch[n + h1 + b]
    total += weights[place + h2]
    place += h2 + 1
    return float(min(max(total, weights[place]), weights[place + 1]))


evaluate_one = compiled(_evaluate_one_py, fastmath={"contract", "reassoc", "nsz"})
"""Return u [m/s^2] of one x (WIDTH,); `weights`, `sizes` of `packed`, `scratch` (x + h1 + h2,)."""


def to_text(law: ExplicitLaw) -> str:
    """Return the law as JSON text."""
    parts = {name: np.round(getattr(law, name), 9).tolist() for name in law.__slots__}
    return json.dumps({"format": FORMAT, **parts})


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
    if law.mean.size != WIDTH:
        raise ValueError(f"the explicit law looks at {law.mean.size} numbers, not at {WIDTH}")
    return law
