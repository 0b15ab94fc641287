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
    """Return a workspace whose package has a program and a script of its own next to its console scripts."""
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


CTRL_C = "import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n"
"""What a program does whom somebody interrupts."""


@pytest.mark.parametrize(
    ("module", "ignoring", "ended"),
    [
        (f"{CTRL_C}print('imported')", "", (130, "", False)),
        (f"{CTRL_C}def main():\n    print('began')", "trap '' INT; ", (0, "began\n", False)),
        (f"def main():\n    print('began', flush=True)\n    exec({CTRL_C!r})", "", (-2, "began\n", True)),
    ],
)
def test_a_program_interrupted_in_its_imports_ends_without_a_traceback(
    workspace: Path, module: str, ignoring: str, ended: tuple[int, str, bool]
) -> None:
    """Not where its shell ignores interrupts, and once it has begun as Python does, by KeyboardInterrupt."""
    build(workspace, where="where:main")
    (workspace / "where.py").write_text(module)
    script = workspace / "install/toy/lib/toy/where"
    done = subprocess.run(
        ["sh", "-c", f'{ignoring}exec "$0" "$1"', sys.executable, script],
        env={"PYTHONPATH": str(workspace)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout, "KeyboardInterrupt" in done.stderr) == ended
