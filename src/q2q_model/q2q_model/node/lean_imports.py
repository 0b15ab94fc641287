"""Import without garbage collection and without numba's import of `coverage`: a third of the import time.

Imported modules are never freed, so collection finds nothing. numba imports `coverage` if it is installed
(colcon depends on it) to report compiled lines; None in sys.modules means "not found" (Python Language
Reference 5.3.1).
"""

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager

UNUSED = "coverage"


@contextmanager
def lean_imports() -> Iterator[None]:
    """Disable garbage collection, and hide `coverage` unless it measures this process."""
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
