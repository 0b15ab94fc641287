"""JSON files that tools write."""

import json
from pathlib import Path


def write_json(document: object, file: Path) -> None:
    """Write a document as JSON; create the folders above the file."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
