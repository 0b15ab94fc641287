"""Say what the explicit law looks at: a pair's errors now, and the drafts along both references.

    x = (e_1, e_1', e_2, e_2', dz, eta_1(tau_1..M), eta_2(tau_1..M))

One vehicle is the first, its strongest neighbour the second. Drafts are those of the references, at M times
of the horizon; nothing is solved. Each of a pair evaluates the same law with itself as the first.

| symbol | name | meaning [unit] |
|---|---|---|
| e e' | | height above the reference [m], climb beyond its [m/s] |
| dz | gap | reference height of the second above the first [m] |
| eta | | vertical draft on the reference [m/s^2] |
| tau | WHEN | [s] ahead |
"""

import numpy as np

from q2q_model.interaction.model import InteractionModel, at_rest
from q2q_model.signals import Array

WHEN = np.array([0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.15, 1.4, 1.7, 2.0])
"""tau [s]: dense where the law must act, to the horizon of 2 s."""
WIDTH = 5 + 2 * WHEN.size
"""Numbers the law looks at."""


def features(errors: Array, references: Array, model: InteractionModel) -> Array:
    """Return x of pairs, (..., WIDTH).

    Args:
        errors: e, e' of the first and of the second, (..., 4).
        references: reference positions of both at WHEN [m], world, (..., 2, M, 3).
        model: the draft's law; a source pushes from where its reference was a delay ago.
    """
    first, second = references[..., 0, :, :], references[..., 1, :, :]
    rel = second - first  # (..., M, 3)
    both = np.stack([rel, -rel])
    eta = model.acceleration(_retarded(both, model), at_rest(both))[..., 2]
    return np.concatenate([errors, rel[..., 0, 2:], eta[0], eta[1]], axis=-1)


def _retarded(rel: Array, model: InteractionModel) -> Array:
    """Return rel (2, ..., M, 3) as it was a delay ago, by its trend along the horizon."""
    if model.max_delay == 0.0:
        return rel
    trend = np.gradient(rel, WHEN, axis=-2)
    return np.asarray(rel - trend * model.delay(rel)[..., None])
