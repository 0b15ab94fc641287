"""NumPy's values in documents that are made in Python."""

import numpy as np


def without_numpy(value: object) -> object:
    """Return a scalar of NumPy as a number of Python, an array as a list; anything else as it is."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
