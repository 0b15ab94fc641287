"""Import without garbage collection and without what numba and rosidl look for in vain: a third of the time.

Imported modules are never freed, so collection finds nothing, and later collections leave them out. numba
imports `coverage` if it is installed (colcon depends on it) to report compiled lines, and `cffi` to call C
from kernels; rosidl_generator_py imports its generator of message code. None in sys.modules means "not
found" (Python Language Reference, section 5.3.1).
"""

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module

UNUSED = ("coverage", "cffi", "rosidl_generator_py.generate_py_impl")
DEFERRED_MODULES = {"numba": "numba.core.typing.cffi_utils", "rclpy": "rosidl_generator_py"}
"""Modules that a package imports on first use, and that then look for UNUSED ones."""


@contextmanager
def lean_imports() -> Iterator[None]:
    """Disable garbage collection, and hide UNUSED modules but those that are imported already."""
    collects, hidden = gc.isenabled(), [name for name in UNUSED if name not in sys.modules]
    gc.disable()
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]  # typeshed knows modules only
    try:
        yield
        for package, module in DEFERRED_MODULES.items():
            if package in sys.modules:
                import_module(module)
        gc.freeze()
    finally:
        for name in hidden:
            del sys.modules[name]
        if collects:
            gc.enable()
