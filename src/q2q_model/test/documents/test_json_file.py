"""JSON files are read back as written, in folders that did not exist."""

import json
import sys
from pathlib import Path

import pytest

from q2q_model.commands.argument_types import output_file
from q2q_model.documents.json_file import text_stream, write_json
from q2q_model.writable_places import STDOUT

DOCUMENT = {"vehicle": "cf1", "z_rmse_m": [0.1, None], "ok": True}


def test_a_document_is_read_back_from_folders_that_were_not_there(tmp_path: Path):
    file = tmp_path / "new" / "folder" / "numbers.json"
    write_json(DOCUMENT, file)
    assert json.loads(file.read_text(encoding="utf-8")) == DOCUMENT


@pytest.mark.parametrize("unknown", [float("nan"), float("inf"), -float("inf")])
def test_a_number_that_is_not_known_is_null_wherever_it_is(unknown: float, tmp_path: Path) -> None:
    write_json({"one": unknown, "rows": [(1.0, unknown)], "deep": {"er": [{"x": unknown}]}}, tmp_path / "it")
    known = {"one": None, "rows": [[1.0, None]], "deep": {"er": [{"x": None}]}}
    assert json.loads((tmp_path / "it").read_text(encoding="utf-8")) == known


def test_a_document_for_standard_output_is_alone_there(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    write_json(DOCUMENT, STDOUT)
    print("text", file=text_stream(STDOUT))
    printed = capsys.readouterr()
    assert (json.loads(printed.out), printed.err) == (DOCUMENT, "text\n")
    assert text_stream(None) is text_stream(tmp_path / "it") is sys.stdout


@pytest.mark.parametrize("name", ["-", "./-"])
def test_a_file_named_by_a_dash_is_a_file(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_json(DOCUMENT, output_file(name))
    assert json.loads((tmp_path / "-").read_text(encoding="utf-8")) == DOCUMENT
    assert capsys.readouterr().out == ""
