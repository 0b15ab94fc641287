"""Lengths and distances of vectors, in their unit, compiled: of numbers, of a vector, of rows of arrays."""

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array


@compiled
def length(x: float, y: float, z: float) -> float:
    """Return the length of a vector x, y, z."""
    return float(np.sqrt(x * x + y * y + z * z))


@compiled
def norm(vector: Array) -> float:
    """Return the length of a vector (3,)."""
    return length(vector[0], vector[1], vector[2])


@compiled
def distance(some: Array, other: Array, row: int) -> float:
    """Return the distance of one row of two arrays (n, 3)."""
    return length(some[row, 0] - other[row, 0], some[row, 1] - other[row, 1], some[row, 2] - other[row, 2])


@compiled
def share_within(vector: Array, most: float) -> float:
    """Return the share of a vector, (3,), up to the norm `most`: at most 1."""
    size = norm(vector)
    return float(most / size) if size > most else 1.0


@compiled
def limit_row(vectors: Array, row: int, most: float) -> None:
    """Shorten a row of vectors (n, 3) to the norm `most`."""
    vectors[row] *= share_within(vectors[row], most)
