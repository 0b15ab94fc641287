"""The notebooks run from top to bottom, and are kept without outputs."""

import json
from pathlib import Path

import matplotlib as mpl
import pytest
from fresh_checkout import ROOT

NOTEBOOKS = sorted(ROOT.glob("docs/notebooks/*.ipynb"))
MAGIC = "%"


def cells(notebook: Path) -> list[str]:
    """Return the code of each cell, without the magics of Jupyter."""
    found = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    code = [one["source"] for one in found if one["cell_type"] == "code"]
    return ["".join(line for line in source if not line.startswith(MAGIC)) for source in code]


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_from_top_to_bottom(notebook: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(notebook.parent)
    monkeypatch.setitem(mpl.rcParams, "backend", "agg")
    names: dict[str, object] = {"__name__": notebook.stem}
    for number, code in enumerate(cells(notebook)):
        exec(compile(code, f"{notebook.name}, code cell {number}", "exec"), names)  # noqa: S102  our own files


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_outputs(notebook: Path):
    found = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    kept = [one for one in found if one["cell_type"] == "code" and (one["outputs"] or one["execution_count"])]
    assert kept == []


def test_the_sweep_is_as_short_as_its_title_says():
    (code,) = cells(ROOT / "docs/notebooks/sweep.ipynb")
    lines = [line for line in code.splitlines() if line.strip()]
    assert len(lines) <= 15
