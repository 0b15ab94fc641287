"""Tables of Markdown pages."""

from collections.abc import Sequence


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]], words: int) -> str:
    """Return a table whose first `words` columns are words, and whose others are numbers, to the right."""
    marks = ["---"] * words + ["--:"] * (len(head) - words)
    cells = [map(_in_cell, row) for row in (head, *rows)]
    return "\n".join(f"| {' | '.join(row)} |" for row in (cells[0], marks, *cells[1:]))


def _in_cell(text: str) -> str:
    """Return text with bars and <name> escaped for a cell."""
    parts = text.replace("|", r"\|").split("`")
    return "`".join(part if inside % 2 else part.replace("<", "&lt;") for inside, part in enumerate(parts))
