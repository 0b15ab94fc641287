"""Cache of machine code that is invalidated by every dependency of a kernel.

numba's own cache checks only the file of the function: if a called function or a constant changes in another
file, stale machine code runs silently. Here the cache key also contains the digest of kernel_digest.

numba reads only from folders that it can write. Here code is also loaded from one that can only be read: an
installation of another user, a read-only file system.
"""

import fcntl
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile

from q2q_model.compilation.kernel_digest import fields_of_types, kernel_digest

UNREADABLE = (ImportError, AttributeError, EOFError, UnpicklingError, PermissionError)
"""What reading a stored file raises where a module has moved, or the file is cut short or not ours."""


class ReadableFolder:
    """Mixin of numba's locators of folders that also takes one with code that can only be read."""

    def ensure_cache_path(self) -> None:
        """Do nothing if code can be stored in the folder, or is stored there; raise OSError otherwise."""
        try:
            super().ensure_cache_path()  # type: ignore[misc]  # of the locator
        except OSError:
            if not any(Path(self.get_cache_path()).glob("*.nbi")):  # type: ignore[attr-defined]
                raise


class ReadableFolders(CompileResultCacheImpl):  # type: ignore[misc]  # numba has no types
    """Choice of a function's folder, the first readable or writable one of those that numba looks at."""

    _locator_classes = tuple(
        type(one.__name__, (ReadableFolder, one), {})
        for one in CompileResultCacheImpl._locator_classes  # noqa: SLF001
    )


class KernelCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Cache of compiled code keyed by the digest of all dependencies."""

    _impl_class = ReadableFolders

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = KernelIndex(self._cache_path, self._impl.filename_base, stamp)

    def _index_key(self, signature: Any, codegen: Any) -> tuple[object, ...]:  # noqa: ANN401
        digest = kernel_digest(self._py_func)
        return (*super()._index_key(signature, codegen), tuple(fields_of_types(signature)), digest)

    def holds_any(self) -> bool:
        """Return whether the cache holds code for any signature of the current function."""
        digest = kernel_digest(self._py_func)
        index = self._cache_file._load_index()  # noqa: SLF001  numba shows it nowhere else
        kept = (name for key, name in index.items() if key[-2:] == (tuple(fields_of_types(key[0])), digest))
        return any(Path(self._cache_path, name).exists() for name in kept)


class KernelIndex(IndexDataCacheFile):  # type: ignore[misc]  # numba has no types
    """Index of a function's compiled code that processes may fill at once.

    It leaves out code that refers to modules that have since moved, and files that were cut short.
    """

    def save(self, key: tuple[object, ...], data: object) -> None:
        """Add the code of a key to what other processes have added since this one read the index.

        numba reads the index and replaces it: the slower of two processes would drop the code of the other.
        On a full disk or in a folder that cannot be written, the code is not kept.
        """
        try:
            with Path(self._cache_path, "lock").open("a") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX)
                super().save(key, data)
        except OSError:
            warn_of_no_store()

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


@cache
def warn_of_no_store() -> None:
    """Warn, once in a process, that code is not kept; Python's own count of warnings is lost in numba."""
    warnings.warn(
        "machine code cannot be stored, so every start compiles it: set NUMBA_CACHE_DIR to a writable folder",
        RuntimeWarning,
        stacklevel=1,
    )
