"""Reader of plain values into frozen dataclasses: cattrs walks the types, an error names the mistakes.

cattrs alone converts silently (text to numbers, True to 1.0, text to a tuple of letters); the hooks here
refuse that, and word mistakes by key, value, what is expected, and the nearest name. A field `from_` has the
key `from`.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from math import inf, isfinite
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin

import numpy as np
from cattrs import ClassValidationError, Converter, ForbiddenExtraKeysError, IterableValidationError
from cattrs.cols import homogenous_tuple_structure_factory, mapping_structure_factory
from cattrs.gen import make_dict_structure_fn, override

from q2q_model.counted import first_of
from q2q_model.documents.numpy_values import without_numpy
from q2q_model.documents.shown_value import shown_value
from q2q_model.nearest_name import name_hint
from q2q_model.signals.values import Array

T = TypeVar("T")
Hook = Callable[[Any, Any], Any]
"""Returns a plain value as a type; typed as in cattrs."""

MOST = 3
"""Most mistakes in an error."""


class _Key:
    """Type of a key: text, or a number as text."""


class _Cell:
    """Type of an element of an array: a number or a row."""


class _UnexpectedError(ValueError):
    """Error for a value of another type."""

    def __init__(self, value: object, expected: str) -> None:
        super().__init__(value, expected)
        self.value, self.expected = value, expected


def structure(kind: type[T], plain: object, *, extra: bool) -> T:
    """Return plain values as a `kind`; raise ValueError with a sentence for each of the first mistakes."""
    try:
        return _structured(kind, plain, extra=extra)
    except RecursionError as error:
        raise ValueError("it is nested too deeply") from error


def _structured(kind: type[T], plain: object, *, extra: bool) -> T:
    try:
        return _converter(extra).structure(plain, kind)
    except (ClassValidationError, IterableValidationError, _UnexpectedError) as error:
        raise ValueError("; ".join(first_of(list(_mistakes(error, "", kind)), MOST))) from error


def _mistakes(error: Exception, path: str, kind: object) -> Iterator[str]:
    """Yield a sentence for every mistake; `path` leads to the value, of which a `kind` was expected."""
    if isinstance(error, ClassValidationError):
        noted, whole = error.group_exceptions()
        inner = [(one, f"{path}.{_key(note.name)}".lstrip("."), note.type) for one, note in noted]
        for place in (*inner, *((one, path, kind) for one in whole)):
            yield from _mistakes(*place)
    elif isinstance(error, IterableValidationError):
        for one, note in error.group_exceptions()[0]:
            step = f"[{note.index}]" if isinstance(note.index, int) else f".{note.index}"
            yield from _mistakes(one, f"{path}{step}".lstrip("."), note.type)
    elif isinstance(error, _UnexpectedError):
        expected = get_args(kind)[1] if _origin(kind) is Annotated else error.expected
        given = shown_value(error.value)
        yield f"{path} = {given}; must be {expected}" if path else f"got {given}, expected {expected}"
    elif isinstance(error, ForbiddenExtraKeysError):
        known = _keys(error.cl)
        for key in sorted(map(str, error.extra_fields)):
            yield f"{path and f'{path}: '}unknown key {key!r}; {name_hint(key, known)}"
    elif isinstance(error, KeyError) and error.args == (path.rpartition(".")[2],):
        yield f"{path} is missing"
    elif isinstance(error, ValueError):  # of the class itself
        yield f"{path and f'{path}: '}{error}"
    else:
        raise error


@cache
def _converter(extra: bool) -> Converter:
    """Return the converter that ignores unknown keys, or refuses them."""
    made = Converter(forbid_extra_keys=not extra)
    for kind, expected in ((bool, "true or false"), (int, "an integer"), (str, "text")):
        made.register_structure_hook(kind, _after_check(kind, expected, lambda value, _: value))
    made.register_structure_hook(float, _number)
    made.register_structure_hook(_Key, _name)
    made.register_structure_hook(
        _Cell, lambda cell, _: made.structure(cell, Array if isinstance(cell, list | np.ndarray) else float)
    )
    made.register_structure_hook_func(lambda kind: kind is object, lambda value, _: value)
    made.register_structure_hook_func(lambda kind: _origin(kind) is Literal, _choice)
    made.register_structure_hook_func(lambda kind: kind == Array, lambda value, _: _array(value, made))
    made.register_structure_hook_factory(lambda kind: _origin(kind) is tuple, _tuple_hook)
    made.register_structure_hook_factory(lambda kind: _origin(kind) in (dict, Mapping), _mapping_hook)
    made.register_structure_hook_factory(is_dataclass, _dataclass_hook)
    return made


def _origin(kind: object) -> object:
    """Return `get_origin` of a type, as an object: the types that it declares compare with no class."""
    return get_origin(kind)


def _after_check(accepted: type | UnionType, expected: str, hook: Hook) -> Hook:
    """Return a hook that checks the type before; True and False are no numbers."""

    def read(value: object, kind: object) -> object:
        value = without_numpy(value)
        if not isinstance(value, accepted) or isinstance(value, bool) is not (accepted is bool):
            raise _UnexpectedError(value, expected)
        return hook(value, kind)

    return read


def _name(key: object, _: object) -> str:
    """Return a key as text; raise _UnexpectedError for `on`, `no`, `null`, which YAML reads as others."""
    if key is None or isinstance(key, bool):
        raise _UnexpectedError(key, "a name (quote on, off, yes, no and null)")
    return str(key)


def _finite(value: float, _: object) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = inf
    if not isfinite(number):
        raise _UnexpectedError(value, "a finite number")
    return number


_number = _after_check(int | float, "a number", _finite)


def _choice(value: object, kind: object) -> object:
    known, value = get_args(kind), without_numpy(value)
    if value not in known:
        raise _UnexpectedError(value, f"one of {', '.join(map(str, known))}")
    return known[known.index(value)]


def _array(value: object, made: Converter) -> Array:
    rows = made.structure(value, tuple[_Cell, ...])
    if len({np.array(row).shape for row in rows}) > 1:
        raise _UnexpectedError(value, "a list of rows of one length")
    return np.array(rows, dtype=np.float64)


def _tuple_hook(kind: type, made: Converter) -> Hook:
    types = get_args(kind)
    if types[-1] is Ellipsis:
        return _after_check(list | tuple, "a list", homogenous_tuple_structure_factory(kind, made))
    own, expected = made.gen_structure_hetero_tuple(kind), f"a list of {len(types)} values"

    def read(value: list[object], kind: object) -> object:
        if len(value) != len(types):
            raise _UnexpectedError(value, expected)
        return own(value, kind)

    return _after_check(list | tuple, expected, read)


def _mapping_hook(kind: type, made: Converter) -> Hook:
    own: Hook = mapping_structure_factory(kind, made, dict, key_type=_Key)
    return _after_check(Mapping, "a mapping of names to values", own)


def _dataclass_hook(kind: type, made: Converter) -> Hook:
    renamed: dict[str, Any] = {entry.name: override(rename=_key(entry.name)) for entry in fields(kind)}
    own: Hook = make_dict_structure_fn(kind, made, **renamed)
    return _after_check(Mapping, f"a mapping with {', '.join(_keys(kind))}", own)


def _keys(kind: type) -> list[str]:
    return [_key(entry.name) for entry in fields(kind)]


def _key(name: str) -> str:
    return name.rstrip("_")
