"""Where vehicles say they will be: what one MPC may be told by another. No node sends or hears it yet."""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array, Names


@dataclass(frozen=True, slots=True)
class Predictions:
    """Predicted paths of some vehicles."""

    names: Names
    times: Array
    """Rising [s], (K,)."""
    pos: Array
    """[m], world, (n, K, 3)."""


def path_at(told: Predictions, name: str, times: Array) -> Array | None:
    """Return a vehicle's positions [m] at times (K,) [s], (K, 3); held at the ends; None if not told."""
    if name not in told.names:
        return None
    path = told.pos[told.names.index(name)]
    return np.stack([np.interp(times, told.times, path[:, axis]) for axis in range(3)], axis=1)
