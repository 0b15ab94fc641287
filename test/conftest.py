"""Fixtures of the tests across packages."""

import os
import shutil
from pathlib import Path

import pytest
from fresh_checkout import BASE_PYTHON, ROOT, Checkout


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    """Return a checkout of the scripts in a path with a space, where python3 is the base interpreter."""
    root, tools, home = tmp_path / "a house" / "q2q", tmp_path / "bin", tmp_path / "home"
    for folder in ("scripts", "requirements"):
        shutil.copytree(ROOT / folder, root / folder)
    shutil.copy(ROOT / "colcon.meta", root)
    for folder in (tools, home, root / "src"):
        folder.mkdir(parents=True)
    env = {"PATH": f"{tools}:/usr/bin:/bin", "HOME": str(home), "LANG": "C.UTF-8"}
    kept = {name: os.environ[name] for name in ("CC", "CXX") if name in os.environ}
    made = Checkout(root=root, bin=tools, env=env | kept)
    made.tool("python3", f'exec "{BASE_PYTHON}" "$@"')
    return made
