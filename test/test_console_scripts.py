"""scripts/setup.d/console_scripts.py: the installed scripts are those of the entry points."""

import subprocess
import sys
from pathlib import Path

import pytest
from fresh_checkout import ROOT

BY_SETUPTOOLS = "#!/usr/bin/python3\nfrom importlib.metadata import load_entry_point\n"
FOREIGN = {"probe": b"\x7fELF\xff", "probe.sh": b"#!/bin/sh\n"}


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """Return a workspace whose package has a program and a script of its own beside its console scripts."""
    (tmp_path / "build/toy/toy.egg-info").mkdir(parents=True)
    installed = tmp_path / "install/toy/lib/toy"
    installed.mkdir(parents=True)
    for name, content in FOREIGN.items():
        (installed / name).write_bytes(content)
    return tmp_path


def build(workspace: Path, **targets: str) -> dict[str, str]:
    """Install console scripts as setuptools does, rewrite them, and return the text of all but FOREIGN."""
    installed = workspace / "install/toy/lib/toy"
    listed = workspace / "build/toy/toy.egg-info/entry_points.txt"
    listed.unlink(missing_ok=True)  # setuptools writes none where there are no entry points
    if targets:
        listed.write_text("\n".join(["[console_scripts]", *(f"{n} = {t}" for n, t in targets.items())]))
    for name in targets:
        (installed / name).write_text(BY_SETUPTOOLS)
    script = ROOT / "scripts/setup.d/console_scripts.py"
    subprocess.run([sys.executable, "-I", "-S", script, workspace], check=True)
    return {path.name: path.read_text() for path in installed.iterdir() if path.name not in FOREIGN}


def test_a_script_calls_its_entry_point(workspace: Path) -> None:
    (text,) = build(workspace, where="toy.where:main").values()
    assert "from toy.where import main" in text
    assert "sys.exit(main())" in text
    assert "load_entry_point" not in text


def test_scripts_whose_entry_points_are_gone_go_and_others_stay(workspace: Path) -> None:
    """`ros2 run` listed them, and started what no longer was there."""
    assert {*build(workspace, where="toy.where:main", what="toy.what:main")} == {"where", "what"}
    (workspace / "install/toy/lib/toy/by_setuptools").write_text(BY_SETUPTOOLS)
    assert {*build(workspace, Whither="toy.where:main", what="toy.what:main")} == {"Whither", "what"}
    assert build(workspace) == {}
    foreign = {path.name: path.read_bytes() for path in (workspace / "install/toy/lib/toy").iterdir()}
    assert foreign == FOREIGN
