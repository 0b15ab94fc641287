"""Compare compiled kernels with their plain form, in two processes.

    python test/plain_kernels.py record FILE                        # one call of each entry
    NUMBA_DISABLE_JIT=1 python test/plain_kernels.py compare FILE   # the same calls as plain Python

A kernel that only other kernels call is part of their comparison. `compare` prints the largest difference of
each recorded kernel, in results and in arrays written in place, relative to the largest number (or 1).
"""

import importlib
import json
import pickle
import sys
from pathlib import Path

import numpy as np

from q2q_model.compiled import entry_kernels
from q2q_sim.tools.kernels.compile_kernels import import_kernels
from q2q_sim.tools.kernels.kernel_calls import calls

Call = tuple[str, bytes, bytes]
"""Module and function, arguments before the call, arguments and result after it."""


class Recorder:
    """Kernel that keeps its first call."""

    def __init__(self, name: str, made: object, kept: dict[str, Call]) -> None:
        self._name, self._made, self._kept = name, made, kept

    def __call__(self, *args: object) -> object:
        """Return the kernel's result."""
        if self._name in self._kept:
            return self._made(*args)
        before = pickle.dumps(args)
        result = self._made(*args)
        self._kept[self._name] = (self._name, before, pickle.dumps((args, result)))
        return result


def record() -> list[Call]:
    """Return one call of every kernel that Python calls."""
    import_kernels()
    kept: dict[str, Call] = {}
    recorders = {id(one.made): Recorder(one.name, one.made, kept) for one in entry_kernels()}
    for name, module in list(sys.modules.items()):
        for attribute, value in list(vars(module).items()) if name.startswith("q2q_") else ():
            if id(value) in recorders:
                setattr(module, attribute, recorders[id(value)])
    for call in calls():
        call()
    return list(kept.values())


def difference(one: object, other: object) -> float:
    """Return the largest difference of two values, relative to the largest number in them, or to 1."""
    if isinstance(one, tuple):
        return max((difference(a, b) for a, b in zip(one, other, strict=True)), default=0.0)
    if one is None:
        return 0.0 if other is None else np.inf
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray) and one.dtype.names:
        return difference(*(tuple(table[name] for name in one.dtype.names) for table in (one, other)))
    left, right = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    if left.shape != right.shape or not np.array_equal(np.isfinite(left), np.isfinite(right)):
        return np.inf
    left, right = left[np.isfinite(left)], right[np.isfinite(right)]
    scale = max(1.0, float(np.abs(left).max(initial=0.0)))
    return float(np.abs(left - right).max(initial=0.0)) / scale


def compare(recorded: list[Call]) -> dict[str, float]:
    """Return the largest difference of each kernel's plain form from its recorded call."""
    found = {}
    for name, before, after in recorded:
        module, function = name.rsplit(".", 1)
        args = pickle.loads(before)  # noqa: S301  of the process before
        result = getattr(importlib.import_module(module), function)(*args)
        expected = pickle.loads(after)  # noqa: S301
        found[name] = difference(expected, (args, result))
    return found


def main() -> None:
    """Record or compare."""
    action, file = sys.argv[1], Path(sys.argv[2])
    if action == "record":
        file.write_bytes(pickle.dumps(record()))
        print(json.dumps([one.name for one in entry_kernels()]))
    else:
        print(json.dumps(compare(pickle.loads(file.read_bytes()))))  # noqa: S301


if __name__ == "__main__":
    main()
