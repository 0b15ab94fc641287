"""Counts in sentences: "1 tick", "2 ticks", "cf1, cf2, and 3 more"."""

from collections.abc import Sequence

MOST_NAMES = 20
"""Most names in a list."""


def counted(count: int, noun: str) -> str:
    """Return a count and its noun, in the plural, which ends in s, unless the count is one."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def first_of(parts: Sequence[str], most: int) -> list[str]:
    """Return the first `most` parts, and in words how many more there are."""
    rest = [f"and {len(parts) - most} more"] if len(parts) > most else []
    return [*parts[:most], *rest]


def listed(names: Sequence[str]) -> str:
    """Return the first names of vehicles or nodes, and in words how many more there are."""
    return ", ".join(first_of(names, MOST_NAMES))


def difference(names: Sequence[str], expected: Sequence[str]) -> str:
    """Return how names differ from those expected, as "lacks cf2 and has cf9"; empty if they do not."""
    lacking = listed([name for name in expected if name not in names])
    further = listed([name for name in names if name not in expected])
    return " and ".join([f"lacks {lacking}"] * bool(lacking) + [f"has {further}"] * bool(further))
