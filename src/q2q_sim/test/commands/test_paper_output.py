"""`paper --json` without a file prints the rows, and nothing else, to standard output."""

import json
from pathlib import Path

import pytest

from q2q_sim.commands.paper import main


def test_json_without_a_file_is_alone_on_standard_output(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--only", "table1", "--out", str(tmp_path), "--json"]) == 0
    printed = capsys.readouterr()
    inertia = next(one for one in json.loads(printed.out)["rows"] if one["id"] == "table1.inertia_zz")
    assert inertia["ours"] == 7.06e-5
    assert f"paper: {tmp_path / 'index.html'}" in printed.err
