"""Whether a flight is among those that a model or an air was fitted to, by its name."""

from collections.abc import Iterable

IN_FIT = "a flight of this name is in the fit: not held out if it is this one"
"""Remark: files of models and airs name their flights, and strangers may have one name (`bag`)."""


def is_among(name: str, fitted: Iterable[str]) -> bool:
    """Return whether a flight is among others; the folders before a name may be missing in either."""
    return any(f"/{name}".endswith(f"/{one}") or f"/{one}".endswith(f"/{name}") for one in fitted)
