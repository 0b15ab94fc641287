"""The paper's interaction model: two tanh networks under a Gaussian envelope.

    eta_role(dr) = exp(-dxy^2 / (2 eps^2)) exp(-dz^2 / (2 d^2)) f_role(dxy, |dz|)             (15)
    f(dxy, |dz|) = w2 . tanh(W1 (dxy, |dz|) + b1) + b2                                        section 3.2

Interpretation: (15) has one network for each of two numbered vehicles. Here each role, lower and upper, has
one, so that vehicles can swap places and there can be more than two. eta acts along z only.

| symbol | name | meaning [unit] |
|---|---|---|
| eps, d | eps, d | widths of the envelope [m] |
| W1 b1 | hidden_weights, hidden_bias | hidden layer, (h, 2) [1/m] and (h,); the paper has h = 40 |
| w2 b2 | output_weights, output_bias | output layer, (h,) and scalar [m/s^2] |
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.downwash.interaction_model import EDGE, PairMotion, Reach
from q2q_model.downwash.roles import lower_share, smooth_gap
from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array

HIDDEN = 40
"""Units of the hidden layer, section 3.2."""


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """Weights of one f."""

    hidden_weights: Array
    hidden_bias: Array
    output_weights: Array
    output_bias: float

    def __post_init__(self) -> None:
        """Check the shapes of the layers."""
        hidden = self.hidden_bias.size
        if self.hidden_weights.shape != (hidden, 2) or self.output_weights.shape != (hidden,):
            raise ValueError(
                f"a network with {hidden} hidden biases needs hidden weights ({hidden}, 2) and output "
                f"weights ({hidden},), not {self.hidden_weights.shape} and {self.output_weights.shape}"
            )

    def __call__(self, across: Array, gap: Array) -> Array:
        """Return f [m/s^2], (...,), at horizontal and vertical distances [m], (...,)."""
        inputs = np.stack([across, gap], axis=-1)  # (..., 2)
        hidden = np.tanh(inputs @ self.hidden_weights.T + self.hidden_bias)  # (..., h)
        return np.asarray(hidden @ self.output_weights + self.output_bias)


@dataclass(frozen=True, slots=True)
class EnvelopeNetwork:
    """Two networks under a Gaussian envelope; an InteractionModel."""

    lower: Network
    upper: Network
    eps: float = Cylinder().eps
    d: float = Cylinder().d

    def __post_init__(self) -> None:
        """Check the widths of the envelope."""
        for name, value in (("eps", self.eps), ("d", self.d)):
            if not 0.0 < value < 10.0:
                raise ValueError(f"EnvelopeNetwork.{name} = {value}; must be above 0 and below 10 m")

    @property
    def reach(self) -> Reach:
        """Return the distances at which the envelope has fallen to 1e-4."""
        return Reach(horizontal=EDGE * self.eps, vertical=EDGE * self.d)

    @property
    def max_delay(self) -> float:
        """Return zero [s]: the paper models no transport delay."""
        return 0.0

    def delay(self, rel_pos: Array) -> Array:
        """Return zeros [s], (...,)."""
        return np.zeros(rel_pos.shape[:-1])

    def acceleration(self, rel_pos: Array, motion: PairMotion) -> Array:  # noqa: ARG002
        """Return eta [m/s^2], world, (..., 3); (15) depends on the relative position alone."""
        dz = rel_pos[..., 2]
        across, gap, share = np.hypot(rel_pos[..., 0], rel_pos[..., 1]), smooth_gap(dz), lower_share(dz)
        envelope = np.exp(-(across**2) / (2.0 * self.eps**2) - dz**2 / (2.0 * self.d**2))
        eta = np.zeros(rel_pos.shape)
        eta[..., 2] = envelope * (share * self.lower(across, gap) + (1.0 - share) * self.upper(across, gap))
        return eta

    def deviation(self, rel_pos: Array, motion: PairMotion) -> Array:  # noqa: ARG002
        """Return NaN [m/s^2], (..., 3): the paper gives no uncertainty."""
        return np.full(rel_pos.shape, np.nan)
