"""Numba compilation with a cache that is invalidated by every dependency of a kernel.

numba's own cache checks only the file of the function: if a called function or a constant changes in another
file, stale machine code runs silently. Here the cache key also contains a digest of everything the function
uses, across files: bytecode and constants of the function and of the kernels it calls, the numbers it reads
by name (not as `module.NAME`: import the name), and the fields of named tuples, which machine code reads by
index. Compile with `compiled`, never with `njit`, so that set-up can compile all KERNELS. Call a kernel with
one array layout only: each layout is compiled separately, which takes seconds in flight. A call with a
NamedTuple takes three times as long as one with a plain tuple: where that counts, a kernel takes plain ones,
and makes NamedTuples of them inside.
"""

import fcntl
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from pickle import UnpicklingError
from types import CodeType, FunctionType
from typing import Any, TypeVar, overload

from numba import njit, types
from numba.core import event
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.dispatcher import Dispatcher

Function = TypeVar("Function", bound=Callable[..., object])


@dataclass(frozen=True, slots=True)
class Kernel:
    """Registered compiled function."""

    name: str
    """Module and qualified name."""
    function: FunctionType
    cache: "_CompleteCache | None"
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


UNREADABLE = (ImportError, AttributeError, EOFError, UnpicklingError)
"""What reading a stored file raises where a module has moved, or the file was cut short."""

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


def _store(function: Callable[..., object]) -> "_CompleteCache | None":
    try:
        return _CompleteCache(function)
    except RuntimeError:
        _warn_of_no_store()
        return None


@cache
def _warn_of_no_store() -> None:
    """Warn, once in a process, that code is not kept; Python's own count of warnings is lost in numba."""
    warnings.warn(
        "machine code cannot be stored, so every start compiles it: set NUMBA_CACHE_DIR to a folder that "
        "can be written",
        RuntimeWarning,
        stacklevel=1,
    )


def entry_kernels() -> list[Kernel]:
    """Return the kernels that Python calls: those called by other kernels are part of the callers' code."""
    parts = {called for kernel in KERNELS for called in _called_by(kernel.function)}
    return [one for one in KERNELS if one.function not in parts]


def uncached_kernels() -> list[str]:
    """Return the names of the entries whose current machine code is not cached."""
    return [kernel.name for kernel in entry_kernels() if not (kernel.cache and kernel.cache.holds_any())]


def uncalled_kernels() -> list[str]:
    """Return the names of the kernels this process has called neither from Python nor from other kernels."""
    called: set[FunctionType] = set()
    callers = [one.function for one in KERNELS if isinstance(one.made, Dispatcher) and one.made.overloads]
    while callers:
        one = callers.pop()
        if one not in called:
            called.add(one)
            callers.extend(_called_by(one))
    return [kernel.name for kernel in KERNELS if kernel.function not in called]


def twice_compiled() -> list[str]:
    """Return the names of the kernels that this process has called with several types or array layouts."""
    return [one.name for one in KERNELS if isinstance(one.made, Dispatcher) and len(one.made.overloads) > 1]


class _Index(IndexDataCacheFile):  # type: ignore[misc]  # numba has no types
    """Index of a function's compiled code that processes may fill at once.

    It leaves out code that refers to modules that have since moved, and files that were cut short.
    """

    def save(self, key: tuple[object, ...], data: object) -> None:
        """Add the code of a key to what other processes have added since this one read the index.

        numba reads the index and replaces it: the slower of two processes would drop the code of the other.
        On a full disk, say, the code is not kept.
        """
        try:
            with Path(self._cache_path, "lock").open("a") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX)
                super().save(key, data)
        except OSError:
            _warn_of_no_store()

    def _load_index(self) -> dict[tuple[Any, ...], str]:
        try:
            found: dict[tuple[Any, ...], str] = super()._load_index()
        except UNREADABLE:
            return {}
        return found

    def load(self, key: tuple[object, ...]) -> object:
        """Return the code of a key; None if there is none that can be read."""
        try:
            return super().load(key)
        except UNREADABLE:
            return None


class _CompleteCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Cache of compiled code keyed by the digest of all dependencies."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = _Index(self._cache_path, self._impl.filename_base, stamp)

    def _index_key(self, signature: Any, codegen: Any) -> tuple[object, ...]:  # noqa: ANN401
        digest = kernel_digest(self._py_func)
        return (*super()._index_key(signature, codegen), tuple(_fields(signature)), digest)

    def holds_any(self) -> bool:
        """Return whether the cache holds code for any signature of the current function."""
        digest = kernel_digest(self._py_func)
        index = self._cache_file._load_index()  # noqa: SLF001  numba shows it nowhere else
        kept = (name for key, name in index.items() if key[-2:] == (tuple(_fields(key[0])), digest))
        return any(Path(self._cache_path, name).exists() for name in kept)


class _CompilationListener(event.Listener):  # type: ignore[misc]  # numba has no types
    """Listener that records every compilation in COMPILED."""

    def on_start(self, event: event.Event) -> None:
        """Record the kernel."""
        function = event.data["dispatcher"].py_func
        COMPILED.append(f"{function.__module__}.{function.__qualname__}")

    def on_end(self, event: event.Event) -> None:
        """Do nothing."""


event.register("numba:compile", _CompilationListener())


def kernel_digest(function: FunctionType) -> str:
    """Return a digest of a function and of all kernels and constants that it uses."""
    found = sha256()
    for part in _parts(function, set()):
        found.update(part.encode() + b"\0")
    return found.hexdigest()


def _parts(function: FunctionType, seen: set[FunctionType]) -> Iterator[str]:
    if function in seen:
        return
    seen.add(function)
    for cell in function.__closure__ or ():
        yield repr(cell.cell_contents)
    for code in _codes(function.__code__):
        yield code.co_code.hex()
        yield repr([_ordered(const) for const in code.co_consts if not isinstance(const, CodeType)])
        for name in code.co_names:
            yield from _parts_of(name, function.__globals__.get(name), seen)


def _called_by(function: FunctionType) -> Iterator[FunctionType]:
    values = (function.__globals__.get(name) for code in _codes(function.__code__) for name in code.co_names)
    return (value.py_func for value in values if isinstance(value, Dispatcher))


def _parts_of(name: str, value: object, seen: set[FunctionType]) -> Iterator[str]:
    yield name
    if isinstance(value, Dispatcher):
        yield repr([(key, _ordered(option)) for key, option in sorted(value.targetoptions.items())])
        yield from _parts(value.py_func, seen)
    elif isinstance(value, type) and issubclass(value, tuple):
        yield repr((getattr(value, "_fields", ()), getattr(value, "_field_defaults", {})))
    elif isinstance(value, bool | int | float | str | tuple):
        yield repr(value)


def _fields(kinds: Iterable[types.Type]) -> Iterator[tuple[str, ...]]:
    """Yield the current fields of every named tuple in the types, also those within others."""
    for kind in kinds:
        if isinstance(kind, types.BaseNamedTuple):
            yield kind.instance_class._fields
        if isinstance(kind, types.BaseTuple):
            yield from _fields(kind.types)


def _ordered(value: object) -> object:
    """Return a set as a sorted list, whose text is the same in every process; other values unchanged."""
    return sorted(map(repr, value)) if isinstance(value, set | frozenset) else value


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a function's code and that of its nested functions."""
    yield code
    for const in code.co_consts:
        if isinstance(const, CodeType):
            yield from _codes(const)
