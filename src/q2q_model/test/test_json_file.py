"""JSON files are read back as written, in folders that did not exist."""

import json
from pathlib import Path

from q2q_model.documents.json_file import write_json

DOCUMENT = {"vehicle": "cf1", "z_rmse_m": [0.1, None], "ok": True}


def test_a_document_is_read_back_from_folders_that_were_not_there(tmp_path: Path):
    file = tmp_path / "new" / "folder" / "numbers.json"
    write_json(DOCUMENT, file)
    assert json.loads(file.read_text(encoding="utf-8")) == DOCUMENT
