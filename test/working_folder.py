"""Folder of a reader of the documents: scripts, sources, bags, and the files that a document has them write.

Set-up and built packages are those of the real checkout, so that nothing is built or compiled again. A Python
file that a document writes or changes under `src/` is imported in place of the checkout's own:
`sitecustomize.py` says which.
"""

import ast
import shutil
from pathlib import Path

from documentation import Block
from fresh_checkout import ROOT

COPIED = ("pyproject.toml", "requirements")
ENV_SH = """source "{root}/scripts/env.sh"
export PYTHONPATH="{folder}${{PYTHONPATH:+:$PYTHONPATH}}"
"""
SETUP = """#!/usr/bin/env bash
exec "{root}/scripts/setup" "$@"
"""
SITE = '''"""Import these modules from here."""
import sys
from importlib.util import spec_from_file_location
FILES = {files!r}
class Here:
    @staticmethod
    def find_spec(name, path=None, target=None):
        return spec_from_file_location(name, FILES[name]) if name in FILES else None
sys.meta_path.insert(0, Here)
'''


class WorkingFolder:
    """Folder of one reader."""

    def __init__(self, folder: Path) -> None:
        """Lay out the folder."""
        self.folder = folder
        self._files: dict[str, str] = {}
        for name in ("scripts", "src"):
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in COPIED:
            (folder / name).symlink_to(ROOT / name)
        (folder / "bags").symlink_to(ROOT / "bags")
        (folder / "out").mkdir()
        for name, text in (("env.sh", ENV_SH), ("setup", SETUP)):
            (folder / "scripts" / name).write_text(text.format(root=ROOT, folder=folder))

    def put(self, block: Block) -> None:
        """Write, append or replace the text of a block."""
        path = self.folder / block.file
        if block.action == "write":
            path.write_text(block.text)
        elif block.action == "append":
            path.write_text(f"{path.read_text()}\n{block.text}")
        else:
            path.write_text(with_assignment(path.read_text(), block.name, block.text))
        if path.suffix == ".py" and path.is_relative_to(self.folder / "src") and "test" not in path.parts:
            self._import(path)

    def _import(self, path: Path) -> None:
        """Let every Python process of this folder import this file in place of the checkout's."""
        inside = path.relative_to(self.folder / "src").parts[1:]
        self._files[".".join((*inside[:-1], path.stem))] = str(path)
        (self.folder / "sitecustomize.py").write_text(SITE.format(files=self._files))


def with_assignment(source: str, name: str, text: str) -> str:
    """Return Python source where `text` stands in the place of the assignment to a name.

    Raises:
        ValueError: nothing is assigned to that name at the top level.
    """
    lines = source.splitlines()
    for node in ast.parse(source).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(one, ast.Name) and one.id == name for one in targets):
            return "\n".join([*lines[: node.lineno - 1], text.rstrip(), *lines[node.end_lineno :], ""])
    raise ValueError(f"{name} is assigned nowhere in it")
