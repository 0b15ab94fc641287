"""Copies of what a user's code is given, and a check of the arrays that it returns."""

from dataclasses import Field, fields, replace
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from q2q_model.own_class import error_line
from q2q_model.signals.values import Array


class _Dataclass(Protocol):
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


Given = TypeVar("Given", bound=_Dataclass)


def own_copy(given: Given) -> Given:
    """Return a dataclass with copies of its arrays, in which arithmetic in place changes nothing of ours."""
    values = {field.name: getattr(given, field.name) for field in fields(given)}
    arrays = {name: value.copy() for name, value in values.items() if isinstance(value, np.ndarray)}
    return replace(given, **arrays)


def checked_array(output: object, shape: tuple[int, ...]) -> Array:
    """Return an output as an array of numbers of a shape.

    Raises:
        ValueError: it is no such array; the message continues a sentence that begins with its name.
    """
    needed = f"must be floats of shape {shape}"
    try:
        given = np.asarray(output)
    except Exception as error:  # of a user's class: a tensor of torch that requires grad raises RuntimeError
        raise ValueError(f"is not an array ({error_line(error)}); {needed}") from error
    if given.shape != shape or given.dtype.kind not in "fiu":
        raise ValueError(f"is {given.dtype} of shape {given.shape}; {needed}")
    return given
