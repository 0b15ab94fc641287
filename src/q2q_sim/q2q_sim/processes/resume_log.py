"""Finished work in a file, mostly of JSON lines, from which an interrupted run resumes."""

import fcntl
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO, TypeVar

from q2q_model.node.exclusive_use import claim

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
            raise _in_use(log) from used
        yield file


@contextmanager
def exclusive_file(file: Path) -> Iterator[None]:
    """Keep a file, which may be replaced by a new one, from other runs until the block or the process ends.

    Raises:
        ValueError: another run uses it.
    """
    try:
        held = claim(str(file.resolve()))
    except ValueError as used:
        raise _in_use(file) from used
    with held:
        yield


def _in_use(file: Path) -> ValueError:
    return ValueError(f"{file} is written by another run: wait for it, or name another place")


def read_entries(log: Path, entry_from: Callable[[Mapping[str, object]], Entry]) -> list[Entry]:
    """Return the entries of a file; remove its last line if that has no end, as after a kill.

    `entry_from` returns an entry from its document, or raises ValueError.

    Raises:
        ValueError: the file has other content; it is left as it is.
    """
    text = log.read_text(encoding="utf-8") if log.exists() else ""
    *lines, incomplete = text.split("\n")
    found = []
    for number, line in enumerate(lines, start=1):
        try:
            found.append(entry_from(json.loads(line)))
        except (ValueError, RecursionError) as wrong:
            raise ValueError(
                f"{log}, line {number}: {wrong}; remove the line, or the file to start again"
            ) from wrong
    if incomplete:
        log.write_text(text.removesuffix(incomplete), encoding="utf-8")
    return found
