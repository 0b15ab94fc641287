"""Conversion of frozen dataclasses to plain JSON values and back, with every value checked.

A field may be a bool, int, float, str, NumPy array, a tuple of these, another dataclass, a mapping from names
to one of them, or one of them or None. NaN and infinity are rejected, because JSON has neither.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from types import NoneType, UnionType
from typing import TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from q2q_model.signals.values import Array

T = TypeVar("T")
Plain = bool | int | float | str | None | list["Plain"] | dict[str, "Plain"]
"""Value that json reads and writes."""


class PlainValueError(ValueError):
    """Error for a value that does not fit its field."""


def to_plain(value: object, path: str = "") -> Plain:
    """Return `value` as JSON values; raise PlainValueError for a number that is not finite."""
    if is_dataclass(value):
        return {f.name: to_plain(getattr(value, f.name), f"{path}.{f.name}") for f in fields(value)}
    if isinstance(value, np.ndarray):
        return to_plain(value.tolist(), path)
    if isinstance(value, Mapping):
        return {str(name): to_plain(item, f"{path}.{name}") for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain(item, f"{path}[{k}]") for k, item in enumerate(value)]
    if isinstance(value, float) and not math.isfinite(value):
        raise PlainValueError(f"{path.lstrip('.')} = {value}: only finite numbers can be written")
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise PlainValueError(f"{path.lstrip('.')} is a {type(value).__name__}: it has no plain form")


def from_plain(cls: type[T], plain: Plain, path: str) -> T:
    """Return a `cls` made of `plain`; raise PlainValueError for a value that does not fit its field.

    Args:
        cls: a dataclass.
        plain: JSON value.
        path: name of `plain` in messages.
    """
    if not isinstance(plain, dict):
        raise PlainValueError(f"{path} is {_show(plain)}: expected an object with named fields")
    hints = get_type_hints(cls)
    known = {entry.name: entry for entry in fields(cls)}  # type: ignore[arg-type]  # cls is a dataclass
    for name in plain:
        if name not in known:
            raise PlainValueError(f"{path}.{name} is unknown; known are {', '.join(known)}")
    for name, entry in known.items():
        if name not in plain and entry.default is MISSING and entry.default_factory is MISSING:
            raise PlainValueError(f"{path}.{name} is missing")
    values = {name: _read(hints[name], item, f"{path}.{name}") for name, item in plain.items()}
    try:
        return cls(**values)
    except ValueError as error:
        raise PlainValueError(f"{path}: {error}") from error


def _read(hint: object, plain: Plain, path: str) -> object:
    if hint == Array:
        return _array(plain, path)
    if get_origin(hint) is UnionType:
        options = [option for option in get_args(hint) if option is not NoneType]
        return None if plain is None else _read(options[0], plain, path)
    if get_origin(hint) is Mapping:
        return _mapping(get_args(hint)[1], plain, path)
    if get_origin(hint) is tuple:
        return _tuple(get_args(hint), plain, path)
    if isinstance(hint, type) and is_dataclass(hint):
        return from_plain(hint, plain, path)
    if isinstance(hint, type) and hint in _READERS:
        return _READERS[hint](plain, path)
    raise TypeError(f"{path}: fields of type {hint} have no plain form")


def _float(plain: Plain, path: str) -> float:
    if isinstance(plain, bool) or not isinstance(plain, int | float) or not math.isfinite(plain):
        raise PlainValueError(f"{path} is {_show(plain)}: expected a finite number")
    return float(plain)


def _int(plain: Plain, path: str) -> int:
    if isinstance(plain, bool) or not isinstance(plain, int):
        raise PlainValueError(f"{path} is {_show(plain)}: expected a whole number")
    return plain


def _bool(plain: Plain, path: str) -> bool:
    if not isinstance(plain, bool):
        raise PlainValueError(f"{path} is {_show(plain)}: expected true or false")
    return plain


def _str(plain: Plain, path: str) -> str:
    if not isinstance(plain, str):
        raise PlainValueError(f"{path} is {_show(plain)}: expected a text")
    return plain


def _list(plain: Plain, path: str) -> list[Plain]:
    if not isinstance(plain, list):
        raise PlainValueError(f"{path} is {_show(plain)}: expected a list")
    return plain


def _mapping(hint: object, plain: Plain, path: str) -> dict[str, object]:
    if not isinstance(plain, dict):
        raise PlainValueError(f"{path} is {_show(plain)}: expected an object with named entries")
    return {name: _read(hint, item, f"{path}.{name}") for name, item in plain.items()}


def _tuple(hints: tuple[object, ...], plain: Plain, path: str) -> tuple[object, ...]:
    items = _list(plain, path)
    if len(hints) == 2 and hints[1] is Ellipsis:
        hints = (hints[0],) * len(items)
    if len(hints) != len(items):
        raise PlainValueError(f"{path} has {len(items)} values: expected {len(hints)}")
    return tuple(
        _read(hint, item, f"{path}[{k}]") for k, (hint, item) in enumerate(zip(hints, items, strict=True))
    )


def _array(plain: Plain, path: str) -> Array:
    items = _list(plain, path)
    rows = [
        _array(x, f"{path}[{k}]") if isinstance(x, list) else _float(x, f"{path}[{k}]")
        for k, x in enumerate(items)
    ]
    if len({np.shape(row) for row in rows}) > 1:
        raise PlainValueError(f"{path} has rows of different lengths")
    return np.array(rows, dtype=np.float64)


_READERS: Mapping[type, Callable[[Plain, str], object]] = {float: _float, int: _int, bool: _bool, str: _str}


def _show(plain: Plain) -> str:
    text = repr(plain)
    return text if len(text) <= 40 else f"{text[:37]}..."
