"""Add rows for vehicles that appear while flying."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T", bound=np.generic)


def padded(rows: NDArray[T], extra: int) -> NDArray[T]:
    """Return `rows` (n, ...) with `extra` rows of zeros after it."""
    return np.concatenate([rows, np.zeros((extra, *rows.shape[1:]), dtype=rows.dtype)])
