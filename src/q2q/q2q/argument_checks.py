"""Checks of arguments that Python would take as they are: errors say what was given and what is allowed."""

from math import inf
from pathlib import Path

import numpy as np

from q2q_model.writable_places import writable_folder


def folder_to_write(name: str, given: object) -> Path:
    """Return the path of a folder to write to.

    Raises:
        TypeError: the argument is no path.
        ValueError: it is a file, is to lie in a file, or cannot be written.
    """
    if not isinstance(given, str | Path):
        raise TypeError(f"{name} = {given!r}; must be the path of a folder")
    try:
        return writable_folder(Path(given))
    except ValueError as refusal:
        raise ValueError(f"{name}: {refusal}") from refusal


def check_flags(**given: object) -> None:
    """Raise TypeError for the first argument that is neither True nor False: "no" would count as True."""
    for name, value in given.items():
        if not isinstance(value, bool | np.bool_):
            raise TypeError(f"{name} = {value!r}; must be True or False")


def check_whole_number(name: str, given: object, least: int) -> None:
    """Check that an argument is a whole number of `least` or more.

    Raises:
        TypeError: it is no whole number.
        ValueError: it is too small.
    """
    expected = f"{name} = {given!r}; must be an integer >= {least}"
    if not isinstance(given, int | np.integer) or isinstance(given, bool):
        raise TypeError(expected)
    if given < least:
        raise ValueError(expected)


def check_positive(name: str, given: object, unit: str) -> None:
    """Check that an argument is a finite number above 0.

    Raises:
        TypeError: it is no number.
        ValueError: it is not finite, or not above 0.
    """
    expected = f"{name} = {given!r}; must be a finite number above 0 {unit}"
    if not isinstance(given, int | float | np.integer | np.floating) or isinstance(given, bool):
        raise TypeError(expected)
    if not 0.0 < float(given) < inf:
        raise ValueError(expected)
