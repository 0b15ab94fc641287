"""Conversion of frozen dataclasses to plain values of YAML and JSON and back, with every value checked.

A field may be a bool, int, float, str, literal, NumPy array, a tuple of these, another dataclass, a mapping
from names to one of them, or one of them or None. NaN and infinity are rejected: JSON has neither.
"""

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import TypeVar

import numpy as np

T = TypeVar("T")
Plain = bool | int | float | str | None | list["Plain"] | dict[str, "Plain"]
"""Value that json reads and writes."""


class PlainValueError(ValueError):
    """Error for a value that does not fit its field."""


def to_plain(value: object, path: str = "") -> Plain:
    """Return `value` as JSON values; raise PlainValueError for a number that is not finite."""
    if is_dataclass(value):
        return {f.name: to_plain(getattr(value, f.name), f"{path}.{f.name}") for f in fields(value)}
    if isinstance(value, np.ndarray | np.generic):
        return to_plain(value.tolist(), path)
    if isinstance(value, Mapping):
        return {str(name): to_plain(item, f"{path}.{name}") for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain(item, f"{path}[{k}]") for k, item in enumerate(value)]
    if isinstance(value, float) and not math.isfinite(value):
        raise PlainValueError(f"{path.lstrip('.')} = {value}: only finite numbers can be written")
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise PlainValueError(f"{path.lstrip('.')} is a {type(value).__name__}, which cannot be written")


def from_plain(kind: type[T], plain: object, where: str, *, extra: bool = False) -> T:
    """Return parsed YAML or JSON as a dataclass, or as a dict or tuple of some.

    Numbers are finite; an integer is read as float where a float is expected; scalars and arrays of NumPy are
    read as numbers and lists; numbers as keys of a mapping become text.
    `Annotated[kind, "[x, y, z] in metres"]` words what is expected.

    Args:
        kind: type of the result.
        plain: parsed value.
        where: what is read, in messages; may be empty.
        extra: ignore unknown keys.

    Raises:
        PlainValueError: naming `where` and the mistakes: key, value and what is expected.
    """
    # its cattrs takes 20 ms to import, and nodes that read no file start without it
    from q2q_model.documents.plain_reader import structure

    try:
        return structure(kind, plain, extra=extra)
    except ValueError as error:
        raise PlainValueError(f"{where}: {error}" if where else str(error)) from error
