"""Digest of everything that the machine code of a kernel depends on, across files.

It contains bytecode and constants of the function and of the kernels it calls, the numbers it reads by name
(not as `module.NAME`: import the name), and the fields of named tuples, which machine code reads by index.
"""

from collections.abc import Iterable, Iterator
from hashlib import sha256
from types import CodeType, FunctionType

from numba import types
from numba.core.dispatcher import Dispatcher


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


def _parts_of(name: str, value: object, seen: set[FunctionType]) -> Iterator[str]:
    yield name
    if isinstance(value, Dispatcher):
        yield repr([(key, _ordered(option)) for key, option in sorted(value.targetoptions.items())])
        yield from _parts(value.py_func, seen)
    elif isinstance(value, type) and issubclass(value, tuple):
        yield repr((getattr(value, "_fields", ()), getattr(value, "_field_defaults", {})))
    elif isinstance(value, bool | int | float | str | tuple):
        yield repr(value)


def _ordered(value: object) -> object:
    """Return a set as a sorted list, whose text is the same in every process; other values unchanged."""
    return sorted(map(repr, value)) if isinstance(value, set | frozenset) else value


def called_kernels(function: FunctionType) -> Iterator[FunctionType]:
    """Return the functions of the kernels that a function calls."""
    values = (function.__globals__.get(name) for code in _codes(function.__code__) for name in code.co_names)
    return (value.py_func for value in values if isinstance(value, Dispatcher))


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a function's code and that of its nested functions."""
    yield code
    for const in code.co_consts:
        if isinstance(const, CodeType):
            yield from _codes(const)


def fields_of_types(kinds: Iterable[types.Type]) -> Iterator[tuple[str, ...]]:
    """Yield the current fields of every named tuple in the types, also those within others."""
    for kind in kinds:
        if isinstance(kind, types.BaseNamedTuple):
            yield kind.instance_class._fields
        if isinstance(kind, types.BaseTuple):
            yield from fields_of_types(kind.types)
