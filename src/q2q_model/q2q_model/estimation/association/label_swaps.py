"""Assignment of swapped labels: a rejected sample goes to the track that it fits.

A sample rejected by the track of its own name is tried on every track without an accepted sample. Pairs
within the track's gate are assigned greedily, nearest first, each sample and track once.
"""

import numpy as np

from q2q_model.signals.values import Array, Mask, Rows


def swapped_sources(measured: Array, expected: Array, gate: Array, rejected: Mask, missing: Mask) -> Rows:
    """Return for each track the row of another name's sample that fits it, (n,); -1 where there is none.

    Args:
        measured: Samples [m], (n, 3).
        expected: Predicted positions [m], (n, 3).
        gate: Largest accepted distance between the two [m], (n,).
        rejected: Samples rejected by the track of their own name, (n,).
        missing: Tracks without an accepted sample, (n,).
    """
    source = np.full(len(gate), -1, dtype=np.intp)
    rows, tracks = np.flatnonzero(rejected), np.flatnonzero(missing)
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
