"""Import without what takes a third of the time: collecting garbage, and numba's search for `coverage`.

Modules stay, so the collector finds nothing among them. numba imports `coverage` wherever it is installed
(colcon brings it) to tell it of compiled lines; None in sys.modules means "not found" (Python Language
Reference 5.3.1).
"""

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager

UNUSED = "coverage"


@contextmanager
def lean_imports() -> Iterator[None]:
    """Import without the collector, and without `coverage` unless it measures this process."""
    collects, hidden = gc.isenabled(), UNUSED not in sys.modules
    gc.disable()
    if hidden:
        sys.modules[UNUSED] = None  # type: ignore[assignment]  # typeshed knows modules only
    try:
        yield
    finally:
        if hidden:
            del sys.modules[UNUSED]
        if collects:
            gc.enable()
