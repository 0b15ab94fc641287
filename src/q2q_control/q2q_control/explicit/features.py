"""Say what the explicit law looks at: a pair's errors now, and the drafts along both references.

    x = (e_1, e_1', e_2, e_2', dz, mean eta_1 in M windows of the horizon, mean eta_2 in the same)

One vehicle is the first, its strongest neighbour the second; each of a pair evaluates the same law with
itself as the first. Drafts are those of the references; nothing is solved. Means, because a draft that passes
between two samples would not be seen.

| symbol | name | meaning [unit] |
|---|---|---|
| e e' | | height above the reference [m], climb beyond its [m/s] |
| dz | gap | reference height of the second above the first [m] |
| eta | | vertical draft on the reference [m/s^2] |
| | EDGES | of the windows [s] ahead |
"""

from itertools import pairwise

import numpy as np

from q2q_model.interaction.model import InteractionModel, at_rest
from q2q_model.signals import Array

WHEN = np.linspace(0.0, 2.0, 41)
"""Where the drafts are looked up [s] ahead: the stages of the horizon."""
EDGES = np.array([0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.15, 1.4, 1.7, 2.0])
"""Windows [s] ahead: narrow where the law must act."""
_INSIDE = [(low - 1e-9 <= WHEN) & (high + 1e-9 >= WHEN) for low, high in pairwise(EDGES)]
MEANS = np.stack(_INSIDE).astype(float)
MEANS /= MEANS.sum(axis=1, keepdims=True)  # (M, WHEN)
WIDTH = 5 + 2 * len(MEANS)
"""Numbers the law looks at."""


def features(errors: Array, references: Array, model: InteractionModel) -> Array:
    """Return x of pairs, (..., WIDTH).

    Args:
        errors: e, e' of the first and of the second, (..., 4).
        references: reference positions of both at WHEN [m], world, (..., 2, 41, 3).
        model: the draft's law; a source pushes from where its reference was a delay ago.
    """
    first, second = references[..., 0, :, :], references[..., 1, :, :]
    rel = second - first  # (..., 41, 3)
    both = np.stack([rel, -rel])
    eta = model.acceleration(_retarded(both, model), at_rest(both))[..., 2]
    return np.concatenate([errors, rel[..., 0, 2:], eta[0] @ MEANS.T, eta[1] @ MEANS.T], axis=-1)


def _retarded(rel: Array, model: InteractionModel) -> Array:
    """Return rel (2, ..., 41, 3) as it was a delay ago, by its trend along the horizon."""
    if model.max_delay == 0.0:
        return rel
    trend = np.gradient(rel, WHEN, axis=-2)
    return np.asarray(rel - trend * model.delay(rel)[..., None])
