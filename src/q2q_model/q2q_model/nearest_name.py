"""Hint to the name that was meant, for errors about an unknown one."""

from collections.abc import Iterable
from difflib import get_close_matches


def name_hint(given: str, known: Iterable[str]) -> str:
    """Return a question with the known name nearest to the given one, or the list of all if none is near."""
    names = list(known)
    near = get_close_matches(given, names, n=1)
    return f"did you mean {near[0]}?" if near else f"choose one of {', '.join(names)}"
