"""Bytes of the arrays that an object keeps alive."""

import gc
from types import FunctionType, ModuleType

import numpy as np


def array_bytes(root: object) -> int:
    """Return the bytes of all arrays that an object leads to, each once; a view counts as its owner."""
    seen: set[int] = set()
    waiting, total = [root], 0
    while waiting:
        one = waiting.pop()
        if id(one) in seen or isinstance(one, type | ModuleType | FunctionType):
            continue
        seen.add(id(one))
        if not isinstance(one, np.ndarray):
            waiting += gc.get_referents(one)
        elif isinstance(one.base, np.ndarray):
            waiting.append(one.base)
        else:
            total += one.nbytes
    return total
