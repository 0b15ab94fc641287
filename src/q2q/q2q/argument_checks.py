"""Checks of arguments that Python would take as they are: errors say what was given and what is allowed."""

import os
from math import inf
from pathlib import Path

import numpy as np


def writable_folder(name: str, given: object) -> Path:
    """Return the path of a folder to write to, which is created if it is not there.

    Raises:
        TypeError: the argument is no path.
        ValueError: there is no such folder and none can be created, or it cannot be written to.
    """
    if not isinstance(given, str | Path):
        raise TypeError(f"{name} = {given!r}: the path of a folder is expected")
    path = Path(given)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as refusal:
        told = f"{name} = {path}: no such folder, and none can be made ({refusal.strerror})"
        raise ValueError(told) from refusal
    if not os.access(path, os.W_OK):
        raise ValueError(f"{name} = {path}: the folder cannot be written to; give another")
    return path


def check_flags(**given: object) -> None:
    """Raise TypeError for the first argument that is neither True nor False: "no" would count as True."""
    for name, value in given.items():
        if not isinstance(value, bool | np.bool_):
            raise TypeError(f"{name} = {value!r}: True or False is expected")


def check_whole_number(name: str, given: object, least: int) -> None:
    """Check that an argument is a whole number of `least` or more.

    Raises:
        TypeError: it is no whole number.
        ValueError: it is too small.
    """
    expected = f"{name} = {given!r}: a whole number of {least} or more is expected"
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
    expected = f"{name} = {given!r}: a finite number above 0 {unit} is expected"
    if not isinstance(given, int | float | np.integer | np.floating) or isinstance(given, bool):
        raise TypeError(expected)
    if not 0.0 < float(given) < inf:
        raise ValueError(expected)
