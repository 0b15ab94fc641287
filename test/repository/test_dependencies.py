"""Every import of a package is named in its package.xml by a rosdep key, and pinned by requirements/.

Keys: rosdistro's rosdep/python.yaml and the ROS packages of Jazzy. A module without any key is installed by
scripts/setup from requirements/run.txt only, and is listed in WITHOUT_KEY.
"""

import ast
import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml
from fresh_checkout import ROOT

PACKAGES = [path.parent for path in sorted(ROOT.glob("src/*/setup.py"))]

KEYS = {
    "matplotlib": "python3-matplotlib",
    "mpl_toolkits": "python3-matplotlib",
    "numba": "python3-numba",
    "numpy": "python3-numpy",
    "rich": "python3-rich",
    "rosbags": "python3-rosbags-pip",
    "scipy": "python3-scipy",
    "torch": "python3-torch",
    "yaml": "python3-yaml",
}
WITHOUT_KEY = {
    "backports",
    "cattrs",
    "cflib",
    "cma",
    "dask",
    "foxglove",
    "llvmlite",
    "mcap",
    "piqp",
    "pyarrow",
    "threadpoolctl",
}

ROS_PACKAGES = {
    "ament_index_python", "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "launch", "launch_ros",
    "nav_msgs",
    "rcl_interfaces", "rclpy", "rosgraph_msgs", "sensor_msgs", "std_msgs", "std_srvs", "visualization_msgs",
}  # fmt: skip

DISTRIBUTIONS = {
    "backports": "backports.zstd",
    "foxglove": "foxglove-sdk",
    "mpl_toolkits": "matplotlib",
    "yaml": "PyYAML",
}
"""Names on the package index that differ from the module's."""


def imports(package: Path) -> set[str]:
    """Return the top-level modules that the code imports, without the standard library and itself."""
    found = set()
    for path in (package / package.name).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module is not None:
                found.add(node.module.partition(".")[0])
    return found - sys.stdlib_module_names - {package.name}


def named(package: Path) -> set[str]:
    """Return the keys that the package's package.xml depends on."""
    tree = ET.parse(package / "package.xml")  # noqa: S314 (our own file)
    return {element.text or "" for element in tree.iter() if element.tag.endswith("depend")}


def pinned(*files: str) -> set[str]:
    """Return the names that requirements files pin with ==, in lower case."""
    lines = "\n".join((ROOT / "requirements" / name).read_text(encoding="utf-8") for name in files)
    return {
        name.lower() for name in re.findall(r"^([A-Za-z0-9_.-]+)(?:\[\w+\])?==", lines, flags=re.MULTILINE)
    }


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_package_xml_names_what_the_code_imports_by_keys_that_exist(package: Path):
    own = {path.name for path in PACKAGES} | {"q2q_msgs"}
    modules = imports(package)
    unknown = modules - own - ROS_PACKAGES - KEYS.keys() - WITHOUT_KEY
    assert not unknown, f"no rosdep key is known here for {sorted(unknown)}: add it to KEYS or WITHOUT_KEY"
    expected = {KEYS.get(name, name) for name in modules - WITHOUT_KEY} | {"python3-pytest"}
    file = f"src/{package.name}/package.xml"
    assert named(package) >= expected, f"{file} lacks {sorted(expected - named(package))}"
    keys = own | ROS_PACKAGES | set(KEYS.values()) | {"python3-pytest", "python3-hypothesis"}
    assert named(package) <= keys, f"{file}: {sorted(named(package) - keys)} are no keys known here"


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_what_a_package_imports_is_pinned(package: Path):
    modules = {
        DISTRIBUTIONS.get(name, name).lower() for name in imports(package) & (KEYS.keys() | WITHOUT_KEY)
    }
    files = ("ros", "run", "radio", "train", "view", "campaign")
    missing = modules - pinned(*(f"{name}.txt" for name in files))
    assert not missing, f"scripts/setup without --dev installs no version of {sorted(missing)}"


@pytest.mark.parametrize("name", ["build", "ros", "run", "dev", "radio", "train", "view", "campaign", "docs"])
def test_every_requirement_is_exact_and_says_why(name: str):
    for line in (ROOT / f"requirements/{name}.txt").read_text(encoding="utf-8").splitlines():
        assert line.startswith("#") or re.fullmatch(r"[A-Za-z0-9_.-]+(\[\w+\])?==\S+  # .+", line), line


@pytest.mark.parametrize("file", sorted(ROOT.glob("src/q2q*/package.xml")), ids=lambda path: path.parent.name)
def test_every_package_repeats_version_contact_and_licence_of_the_citation(file: Path):
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    package = ET.parse(file)  # noqa: S314 (our own file)
    maintainer = package.find("maintainer")
    assert maintainer is not None
    (contact,) = citation["contact"]
    assert (maintainer.text, maintainer.get("email")) == (contact["name"], contact["email"])
    assert package.findtext("version") == citation["version"]
    assert package.findtext("license") == citation["license"]
    setup = file.with_name("setup.py")
    if setup.exists():
        text = setup.read_text(encoding="utf-8")
        assert all(f'"{word}"' in text for word in (contact["email"], citation["version"]))


def test_the_released_version_has_notes():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    notes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## [{citation['version']}] - {citation['date-released']}" in notes


def test_every_field_of_a_message_says_its_unit_or_meaning():
    for path in (ROOT / "src/q2q_msgs/msg").glob("*.msg"):
        for line in path.read_text(encoding="utf-8").splitlines():
            is_field = line.strip() and not line.lstrip().startswith("#")
            assert not is_field or "#" in line, f"{path.name}: no unit and frame on '{line}'"


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_every_data_file_of_a_package_is_installed_with_it(package: Path):
    """Without --symlink-install, colcon copies what setup.py names, and nothing else."""
    (globs,) = re.findall(r"package_data=\{PACKAGE: \[(.*)\]\}", (package / "setup.py").read_text())
    inside = package / package.name
    named = {path for glob in re.findall(r'"([^"]+)"', globs) for path in inside.glob(glob)}
    data = {path for path in inside.rglob("*") if path.is_file() and path.suffix != ".py"}
    data = {path for path in data if "__pycache__" not in path.parts}
    assert data == named
