"""No folder of a package both imports one of its subfolders and is imported by it.

The import rules of pyproject.toml compare the entries of a folder one by one. There, a subfolder may import a
module beside it which does not import the subfolder. Here, all modules that lie in a folder itself count as
one, so that each subfolder is either above or below its folder.
"""

import ast
from collections.abc import Mapping

import pytest
from fresh_checkout import ROOT

OWN = ""
"""The modules that lie in a folder itself."""


def imports_of(sources: Mapping[str, str]) -> dict[str, set[str]]:
    """Return the modules that each module imports, of those given with their text."""
    found: dict[str, set[str]] = {}
    for name, text in sources.items():
        wanted = set()
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ImportFrom) and node.module:
                wanted |= {node.module, *(f"{node.module}.{one.name}" for one in node.names)}
            elif isinstance(node, ast.Import):
                wanted |= {one.name for one in node.names}
        found[name] = (wanted | {f"{one}.__init__" for one in wanted}) & sources.keys()
    return found


def cyclic_subfolders(imports: Mapping[str, set[str]]) -> dict[str, set[str]]:
    """Return the subfolders of each folder that it imports, and that import it, also by way of others."""
    folders = {name.rpartition(".")[0] for name in imports} - {""}
    found = {folder: _cyclic(folder, imports, folders) for folder in folders}
    return {folder: cyclic for folder, cyclic in found.items() if cyclic}


def _cyclic(folder: str, imports: Mapping[str, set[str]], folders: set[str]) -> set[str]:
    inside = [name for name in imports if name.startswith(f"{folder}.")]

    def entry(name: str) -> str:
        first = name.removeprefix(f"{folder}.").partition(".")[0]
        return first if f"{folder}.{first}" in folders else OWN

    reached: dict[str, set[str]] = {entry(name): set() for name in inside}
    for name in inside:
        targets = {entry(one) for one in imports[name] if one.startswith(f"{folder}.")}
        reached[entry(name)] |= targets - {entry(name)}
    for _ in reached:
        for entries in reached.values():
            entries |= {far for near in entries for far in reached[near]}
    return {one for one in reached if one != OWN and OWN in reached[one] and one in reached[OWN]}


def package_sources() -> dict[str, str]:
    """Return the text of each module of the packages by its name; that of a folder as `__init__`."""
    texts = {}
    for path in ROOT.glob("src/*/*/**/*.py"):
        parts = path.relative_to(ROOT / "src").with_suffix("").parts[1:]
        if parts[0] in {"q2q", "q2q_model", "q2q_planner", "q2q_control", "q2q_sim"}:
            texts[".".join(parts)] = path.read_text(encoding="utf-8")
    return texts


def test_no_folder_and_its_subfolder_import_each_other() -> None:
    assert cyclic_subfolders(imports_of(package_sources())) == {}


@pytest.mark.parametrize(
    ("top", "deep", "cyclic"),
    [
        ("import p.deep.inner", "", {}),
        ("", "from p import top", {}),
        ("import p.deep.inner", "from p import top", {"p": {"deep"}}),
        ("import p.deep.inner", "from p.other.between import one", {"p": {"deep", "other"}}),
    ],
    ids=["down", "up", "both", "by way of a third"],
)
def test_a_cycle_between_a_folder_and_its_subfolder_is_found(
    top: str, deep: str, cyclic: dict[str, set[str]]
) -> None:
    sources = {"p.top": top, "p.deep.inner": deep, "p.other.between": "import p.low", "p.low": ""}
    assert cyclic_subfolders(imports_of(sources)) == cyclic
