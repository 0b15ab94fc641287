"""Counts with their nouns in sentences: "1 tick", "2 ticks"."""


def counted(count: int, noun: str) -> str:
    """Return a count and its noun, in the plural, which ends in s, unless the count is one."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
