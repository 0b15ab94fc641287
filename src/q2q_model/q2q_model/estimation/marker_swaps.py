"""Give swapped markers back: take a vehicle's refused sample for the track that it fits.

A sample that its own name's track refuses is tried on every track whose own sample is refused or missing;
the nearest within the track's gate gets it, nearest pair first, each sample and track once.
"""

import numpy as np
from numpy.typing import NDArray

from q2q_model.flights.outliers import Mask
from q2q_model.signals.values import Array


def swapped_sources(
    measured: Array, expected: Array, gate: Array, orphans: Mask, needy: Mask
) -> NDArray[np.intp]:
    """Return for every track the row of another's sample that fits it, (n,); -1 where there is none.

    Args:
        measured: Samples [m], (n, 3).
        expected: Predicted positions [m], (n, 3).
        gate: Largest believable distance between the two [m], (n,).
        orphans: Whose sample was refused by its own track, (n,).
        needy: Which tracks lack a sample, (n,).
    """
    source = np.full(len(gate), -1, dtype=np.intp)
    rows, tracks = np.flatnonzero(orphans), np.flatnonzero(needy)
    distance = np.linalg.norm(expected[tracks, None] - measured[None, rows], axis=-1)
    distance[(distance > gate[tracks, None]) | (tracks[:, None] == rows)] = np.inf
    for _ in range(min(len(rows), len(tracks))):
        track, row = np.unravel_index(np.argmin(distance), distance.shape)
        if np.isinf(distance[track, row]):
            break
        source[tracks[track]] = rows[row]
        distance[track, :] = np.inf
        distance[:, row] = np.inf
    return source
