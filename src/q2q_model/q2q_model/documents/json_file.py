"""JSON files that tools write."""

import json
from pathlib import Path


def write_json(document: object, file: Path) -> None:
    """Write a document as JSON; create the folders above the file.

    Raises:
        OSError: naming the file.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    try:
        file.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(file)) from error
