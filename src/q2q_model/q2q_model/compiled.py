"""Numba compilation by one decorator for all packages, with its list of all kernels.

Compile with `compiled`, never with `njit`, so that the machine code is stored by all it depends on
(kernel_cache), and set-up can compile all KERNELS. Call a kernel with one array layout only: each layout is
compiled separately, which takes seconds in flight. A call with a NamedTuple takes three times as long as one
with a plain tuple: where that counts, a kernel takes plain ones, and makes NamedTuples of them inside.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from types import FunctionType
from typing import TypeVar, overload

from numba import njit
from numba.core import event
from numba.core.dispatcher import Dispatcher

from q2q_model.compilation.kernel_cache import KernelCache, warn_of_no_store
from q2q_model.compilation.kernel_digest import called_kernels

Function = TypeVar("Function", bound=Callable[..., object])


@dataclass(frozen=True, slots=True)
class Kernel:
    """Registered compiled function."""

    name: str
    """Module and qualified name."""
    function: FunctionType
    cache: KernelCache | None
    """Store of its machine code; None if no folder for it can be written."""
    made: Dispatcher | FunctionType
    """Dispatcher; the plain function if numba is disabled."""


FAST: dict[str, object] = {"error_model": "numpy", "fastmath": {"contract", "reassoc", "nsz"}}
"""Options of loops that may divide by zero silently and add in any order."""

BORROWING: dict[str, object] = {"_nrt": False}
"""Options of loops that allocate no array: numba counts no references to the rows that they pass on, which
are atomic operations and took half the time of the physics. It refuses a function that would need them."""

HOT: dict[str, object] = {**BORROWING, "error_model": "numpy", "forceinline": True}
"""Options of functions within such a loop that cost time: no call, which would copy every number and array of
their named tuples, and no test of divisors."""

FAST_HOT: dict[str, object] = {**FAST, **HOT}
"""Options of such functions whose loops may add in any order."""

KERNELS: list[Kernel] = []
"""Kernels of all modules imported so far."""

COMPILED: list[str] = []
"""Names of the kernels compiled (not loaded from the cache) by this process; none in flight."""


@overload
def compiled(function: Function, /, **options: object) -> Function: ...


@overload
def compiled(**options: object) -> Callable[[Function], Function]: ...


def compiled(function: Callable[..., object] | None = None, /, **options: object) -> object:
    """Return the compiled function, registered in KERNELS; `options` go to numba.njit, except `cache`.

    The plain form is the result's `py_func`.
    """
    if function is None:
        return partial(_compiled, options=options)
    return _compiled(function, options)


def _compiled(function: Callable[..., object], options: dict[str, object]) -> object:
    made = njit(**options)(function)
    store = _store(function)
    if store:
        made._cache = store  # noqa: SLF001  what enable_caching does, with our key
    source = getattr(made, "py_func", made)  # with numba disabled, `made` is the function itself
    name = f"{function.__module__}.{function.__qualname__}"
    KERNELS.append(Kernel(name, source, store, made))
    return made


def _store(function: Callable[..., object]) -> KernelCache | None:
    try:
        return KernelCache(function)
    except RuntimeError:
        warn_of_no_store()
        return None


def entry_kernels() -> list[Kernel]:
    """Return the kernels that Python calls: those called by other kernels are part of the callers' code."""
    parts = {called for kernel in KERNELS for called in called_kernels(kernel.function)}
    return [one for one in KERNELS if one.function not in parts]


def uncached_kernels() -> list[str]:
    """Return the names of the entries whose current machine code is not cached."""
    return [kernel.name for kernel in entry_kernels() if not (kernel.cache and kernel.cache.holds_any())]


class _CompilationListener(event.Listener):  # type: ignore[misc]  # numba has no types
    """Listener that records every compilation in COMPILED."""

    def on_start(self, event: event.Event) -> None:
        """Record the kernel."""
        function = event.data["dispatcher"].py_func
        COMPILED.append(f"{function.__module__}.{function.__qualname__}")

    def on_end(self, event: event.Event) -> None:
        """Do nothing."""


event.register("numba:compile", _CompilationListener())
