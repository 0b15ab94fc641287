"""The end of what a program prints."""

from collections import deque
from io import TextIOBase

KEPT_LINES = 20
"""Lines of output that are kept."""


class LastLines(TextIOBase):
    """Text stream that keeps the last lines."""

    def __init__(self) -> None:
        self._lines: deque[str] = deque([""], maxlen=KEPT_LINES)

    def write(self, text: str) -> int:
        """Keep what is written."""
        first, *others = text.split("\n")
        self._lines[-1] += first
        self._lines.extend(others)
        return len(text)

    def text(self) -> str:
        """Return the last lines."""
        return "\n".join(self._lines).strip()
