"""Random networks of the envelope law."""

import numpy as np

from q2q_model.downwash.envelope_network import EnvelopeNetwork, Network


def networks(seed: int = 4) -> EnvelopeNetwork:
    """Return two random networks of 40 units."""
    rng = np.random.default_rng(seed)
    lower, upper = (
        Network(rng.normal(size=(40, 2)), rng.normal(size=40), rng.normal(size=40), float(rng.normal()))
        for _ in range(2)
    )
    return EnvelopeNetwork(lower, upper)
