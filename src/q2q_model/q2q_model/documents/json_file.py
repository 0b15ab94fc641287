"""JSON files that tools write."""

import json
import math
from collections.abc import Mapping
from pathlib import Path

from q2q_model.documents.written_file import write_text

Json = dict[str, "Json"] | list["Json"] | str | float | int | bool | None
"""Document of plain values; numbers that are not finite are written as null."""


def write_json(document: object, file: Path) -> None:
    """Write a document as JSON, null for numbers that are not finite; create the folders above the file.

    Raises:
        OSError: naming the file.
    """
    write_text(json.dumps(with_nulls(document), indent=1, allow_nan=False) + "\n", file)


def with_nulls(document: object) -> object:
    """Return a document with None for every number that is not finite: JSON has none of these."""
    if isinstance(document, Mapping):
        return {name: with_nulls(one) for name, one in document.items()}
    if isinstance(document, list | tuple):
        return [with_nulls(one) for one in document]
    return None if isinstance(document, float) and not math.isfinite(document) else document
