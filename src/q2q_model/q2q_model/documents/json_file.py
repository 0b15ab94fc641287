"""JSON files that tools write."""

import json
import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TextIO

from q2q_model.documents.written_file import write_text
from q2q_model.writable_places import STDOUT

Json = dict[str, "Json"] | list["Json"] | str | float | int | bool | None
"""Document of plain values; numbers that are not finite are written as null."""


def write_json(document: object, file: Path) -> None:
    """Write a document as JSON, null for numbers that are not finite; create the folders above the file.

    STDOUT is printed.

    Raises:
        OSError: naming the file.
    """
    text = json.dumps(with_nulls(document), indent=1, allow_nan=False)
    if file == STDOUT:
        print(text)
    else:
        write_text(text + "\n", file)


def text_stream(file: Path | None) -> TextIO:
    """Return where a command prints its text: standard error if `file`, that of its document, is STDOUT."""
    return sys.stderr if file == STDOUT else sys.stdout


def with_nulls(document: object) -> object:
    """Return a document with None for every number that is not finite: JSON has none of these."""
    if isinstance(document, Mapping):
        return {name: with_nulls(one) for name, one in document.items()}
    if isinstance(document, list | tuple):
        return [with_nulls(one) for one in document]
    return None if isinstance(document, float) and not math.isfinite(document) else document
