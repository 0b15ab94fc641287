"""The wheel of `pip install .`: complete, of one version, and usable without ROS."""

import ast
import os
import re
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

import pytest
from fresh_checkout import ROOT
from hatchling.builders.wheel import WheelBuilder
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PACKAGES = sorted(path.parent for path in ROOT.glob("src/*/*/__init__.py"))
DECLARED = {canonicalize_name(one.name): one for one in map(Requirement, PROJECT["dependencies"])}
OPTIONAL = [Requirement(one) for part in PROJECT["optional-dependencies"].values() for one in part]
ON_INDEX = {"yaml": "pyyaml", "mpl_toolkits": "matplotlib", "backports": "backports-zstd"}
APART = {"cflib", "launch", "launch_ros", "torch"}
"""What licences, launch file and training import; others import it where they call it."""
PINS = re.compile(r"^([A-Za-z0-9_.-]+)==([^\s+]+)", flags=re.MULTILINE)
WITHOUT_ROS = """
import sys
from importlib.abc import MetaPathFinder

class NoRos(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"rclpy", "rosidl_runtime_py", "q2q_msgs", "std_msgs", "geometry_msgs"}:
            raise ImportError(f"{name} is imported: there is no ROS")

sys.meta_path.insert(0, NoRos())
sys.path[:0] = [sys.argv[1]]
sys.path.append(sys.argv[2])

import q2q
from q2q_model.bag.storage.definitions import jazzy_types

assert q2q.__file__.startswith(sys.argv[1])
assert q2q.load_model("measured_law").interaction.strength > 0.0
assert q2q.load_air("room").jet is not None
assert [q2q.scenario(name).name for name in q2q.scenario_names()]
assert "q2q_msgs/msg/SwarmState" in jazzy_types().fielddefs
print("complete")
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the wheel of this checkout."""
    folder = tmp_path_factory.mktemp("wheel")
    (built,) = WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])
    return Path(built)


def contents(wheel: Path) -> set[str]:
    """Return the files of a wheel without its metadata."""
    return {name for name in ZipFile(wheel).namelist() if ".dist-info/" not in name}


def sources() -> Iterator[str]:
    """Yield the files of the packages as a wheel names them, with the data files and messages."""
    for package in PACKAGES:
        inside = (path for path in package.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
        yield from (str(path.relative_to(package.parent)) for path in inside)
        yield from (f"{package.name}/config/{path.name}" for path in package.parent.glob("config/*"))
    yield from (f"q2q_model/msg/{path.name}" for path in ROOT.glob("src/q2q_msgs/msg/*.msg"))


def imported(package: Path) -> set[str]:
    """Return the top-level modules that a package imports at once, without its ros/."""
    found = set()
    for path in package.rglob("*.py"):
        if "ros" not in path.relative_to(package).parts:
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.Import):
                    found |= {alias.name.partition(".")[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and node.module is not None:
                    found.add(node.module.partition(".")[0])
    return found - sys.stdlib_module_names - {path.name for path in PACKAGES}


def test_the_wheel_holds_every_file_of_the_packages_and_no_other(wheel: Path):
    assert contents(wheel) == set(sources())


def test_an_installed_wheel_finds_its_models_airs_scenarios_and_messages_without_ros(
    wheel: Path, tmp_path: Path
):
    site = tmp_path / "site"
    ZipFile(wheel).extractall(site)
    libraries = str(Path(pytest.__file__).parents[1])
    command = [sys.executable, "-I", "-c", WITHOUT_ROS, str(site), libraries]
    home = {"HOME": os.environ.get("HOME", "/")}  # and no PYTHONPATH nor ament prefix
    done = subprocess.run(command, cwd=tmp_path, env=home, capture_output=True, text=True, check=False)
    assert done.stdout == "complete\n", done.stderr


def test_the_version_is_the_same_everywhere(wheel: Path):
    manifests = {str(ET.parse(path).findtext("version")) for path in ROOT.glob("src/*/package.xml")}  # noqa: S314  our own files
    builds = {re.findall(r'version="(.+)"', path.read_text())[0] for path in ROOT.glob("src/*/setup.py")}
    (cited,) = re.findall(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(), flags=re.MULTILINE)
    assert {wheel.name.split("-")[1]} == manifests == builds == {cited}


def test_the_pinned_versions_of_the_workspace_are_in_the_declared_ranges():
    texts = [(ROOT / f"requirements/{name}.txt").read_text() for name in ("ros", "run", "train")]
    pins = {canonicalize_name(name): pin for text in texts for name, pin in PINS.findall(text)}
    outside = [
        f"{one} but {pins[canonicalize_name(one.name)]}"
        for one in (*DECLARED.values(), *OPTIONAL)
        if not one.specifier.contains(pins[canonicalize_name(one.name)])
    ]
    assert outside == []
    flown = {canonicalize_name(name) for name, _ in PINS.findall(texts[1])}
    assert flown == (DECLARED.keys() | {canonicalize_name(one.name) for one in OPTIONAL}) - {"numpy", "torch"}


def test_what_the_packages_import_at_once_is_declared():
    modules = {ON_INDEX.get(one, one) for package in PACKAGES for one in imported(package)}
    assert modules - DECLARED.keys() == APART
