"""Processor time of a call."""

from collections.abc import Callable
from time import process_time

import numpy as np


def least_time(task: Callable[[], object], count: int, repeats: int = 5) -> float:
    """Return the least CPU time of one call [s] over repeats of `count` calls."""
    task()
    least = np.inf
    for _ in range(repeats):
        start = process_time()
        for _ in range(count):
            task()
        least = min(least, (process_time() - start) / count)
    return float(least)
