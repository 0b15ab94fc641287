"""The envelope networks (15) with their derivatives, for training.

    eta = E (w f_lower + (1 - w) f_upper),   E = exp(-dxy^2 / (2 eps^2)) exp(-dz^2 / (2 d^2))
    d eta / d dz = E (w' (f_lower - f_upper) + (w f_lower' + (1 - w) f_upper') gap' - (dz / d^2) (...))

theta is the vector of all weights: W1, b1, w2, b2 of the lower network, then of the upper.

| symbol | name | meaning [unit] |
|---|---|---|
| dxy | across | horizontal distance of a pair [m] |
| dz | dz | z_j - z_i, height of the source above i [m] |
| w, gap | | share of the lower law and smoothed |dz|: q2q_model.downwash.roles |
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.envelope_network import HIDDEN, EnvelopeNetwork, Network
from q2q_model.downwash.roles import BLEND, lower_share, smooth_gap
from q2q_model.signals.values import Array, Rows

ONE = 4 * HIDDEN + 1
"""Number of weights of one network."""
NEVER = 1e-12
"""Share below which a role is not evaluated [-]; its contribution to eta is negligible."""


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Values of eta at samples, and intermediate values for its derivatives."""

    eta: Array
    """[m/s^2], (p,)."""
    slope: Array
    """d eta / d dz [1/s^2], (p,)."""
    parts: tuple["_Part", ...]


@dataclass(frozen=True, slots=True)
class _Part:
    """Samples and hidden units of one role, and the factor of its f in eta."""

    rows: Rows
    inputs: Array
    hidden: Array
    factor: Array


def unpack(theta: Array, eps: float, d: float) -> EnvelopeNetwork:
    """Return the model whose weights are theta (2 * 161,)."""
    return EnvelopeNetwork(lower=_network(theta[:ONE]), upper=_network(theta[ONE:]), eps=eps, d=d)


def pack(model: EnvelopeNetwork) -> Array:
    """Return theta of a model, (322,) for 40 hidden units in each of two networks."""
    nets = (model.lower, model.upper)
    parts = [
        (n.hidden_weights.ravel(), n.hidden_bias, n.output_weights, np.array([n.output_bias])) for n in nets
    ]
    return np.concatenate([np.concatenate(part) for part in parts])


def evaluate(model: EnvelopeNetwork, across: Array, dz: Array) -> Evaluation:
    """Return eta and its slope for samples across, dz (p,)."""
    share, gap = lower_share(dz), smooth_gap(dz)
    tanh = 2.0 * share - 1.0
    sech2 = 1.0 - tanh**2
    share_slope, gap_slope = 0.5 * sech2 / BLEND, tanh + dz * sech2 / BLEND
    envelope = np.exp(-(across**2) / (2.0 * model.eps**2) - dz**2 / (2.0 * model.d**2))
    mixed, mixed_slope, parts = np.zeros_like(dz), np.zeros_like(dz), []
    for net, weight, sign in ((model.lower, share, 1.0), (model.upper, 1.0 - share, -1.0)):
        rows = np.nonzero(weight > NEVER)[0]
        inputs = np.stack([across[rows], gap[rows]], axis=-1)
        hidden = np.tanh(inputs @ net.hidden_weights.T + net.hidden_bias)  # (p, h)
        f = hidden @ net.output_weights + net.output_bias
        f_gap = (1.0 - hidden**2) @ (net.output_weights * net.hidden_weights[:, 1])
        mixed[rows] += weight[rows] * f
        mixed_slope[rows] += sign * share_slope[rows] * f + weight[rows] * f_gap * gap_slope[rows]
        parts.append(_Part(rows, inputs, hidden, envelope[rows] * weight[rows]))
    slope = envelope * (mixed_slope - dz / model.d**2 * mixed)
    return Evaluation(eta=envelope * mixed, slope=slope, parts=tuple(parts))


def pullback(model: EnvelopeNetwork, at: Evaluation, cotangent: Array) -> Array:
    """Return the gradient of sum(cotangent * eta) with respect to theta, (322,), for cotangent (p,)."""
    return np.concatenate(
        [_pull(net, part, cotangent) for net, part in zip((model.lower, model.upper), at.parts, strict=True)]
    )


def output_features(at: Evaluation, samples: int) -> Array:
    """Return d eta / d (w2, b2) of both networks, (p, 82): eta is linear in them."""
    features = np.zeros((samples, 2 * (HIDDEN + 1)))
    for k, part in enumerate(at.parts):
        block = np.concatenate((part.hidden, np.ones((part.hidden.shape[0], 1))), axis=1)
        features[part.rows, k * (HIDDEN + 1) : (k + 1) * (HIDDEN + 1)] = part.factor[:, None] * block
    return features


def _pull(net: Network, part: _Part, cotangent: Array) -> Array:
    weight = part.factor * cotangent[part.rows]  # (p,)
    inner = weight[:, None] * (1.0 - part.hidden**2) * net.output_weights  # (p, h)
    return np.concatenate(
        [(inner.T @ part.inputs).ravel(), inner.sum(axis=0), weight @ part.hidden, [weight.sum()]]
    )


def _network(theta: Array) -> Network:
    h = HIDDEN
    return Network(
        theta[: 2 * h].reshape(h, 2), theta[2 * h : 3 * h], theta[3 * h : 4 * h], float(theta[4 * h])
    )
