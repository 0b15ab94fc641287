"""Finished work of a campaign in a file of JSON lines, from which an interrupted campaign resumes."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

Entry = TypeVar("Entry")


def read_entries(log: Path, entry_from: Callable[[Mapping[str, object]], Entry]) -> list[Entry]:
    """Return the entries of a file, without an incomplete last line.

    `entry_from` returns an entry from its document, or raises ValueError.

    Raises:
        ValueError: the file has other content.
    """
    lines = log.read_text(encoding="utf-8").splitlines() if log.exists() else []
    found = []
    for number, line in enumerate(lines, start=1):
        try:
            found.append(entry_from(json.loads(line)))
        except ValueError as wrong:
            if number < len(lines):
                raise ValueError(f"{log}, line {number}: {wrong}; delete the file to start anew") from wrong
    return found


def drop_incomplete_line(log: Path) -> None:
    """Remove an incomplete last line."""
    text = log.read_text(encoding="utf-8") if log.exists() else ""
    if text and not text.endswith("\n"):
        log.write_text(text[: text.rfind("\n") + 1], encoding="utf-8")
