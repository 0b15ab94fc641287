"""Finished work in a file of JSON lines, from which an interrupted run of an experiment resumes."""

import fcntl
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO, TypeVar

Entry = TypeVar("Entry")


@contextmanager
def exclusive_log(log: Path) -> Iterator[TextIO]:
    """Yield a file to append to, which no other run may use until the block or the process ends.

    Raises:
        ValueError: another run uses it.
    """
    with log.open("a", encoding="utf-8") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as used:
            raise ValueError(f"{log} is written by another run: wait for it, or name another place") from used
        yield file


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
                raise ValueError(f"{log}, line {number}: {wrong}; delete the file to start again") from wrong
    return found


def drop_incomplete_line(log: Path) -> None:
    """Remove an incomplete last line."""
    text = log.read_text(encoding="utf-8") if log.exists() else ""
    if text and not text.endswith("\n"):
        log.write_text(text[: text.rfind("\n") + 1], encoding="utf-8")
