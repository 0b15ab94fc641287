"""The small ros2 lists and starts what the ament index holds, hints at near names, and shadows nothing."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from fresh_checkout import ROOT

ROS2 = ROOT / "scripts/ros2-small/ros2"

# A first line that stands a space in the interpreter's path, as pip writes it.
NODE = f"""#!/bin/sh
'''exec' "{sys.executable}" "$0" "$@"
' '''
import signal, sys
if sys.argv[1:2] == ["exit"]:
    sys.exit(int(sys.argv[2]))
numbers = {{signal.SIGINT, signal.SIGTERM}}
signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
print("ready", *sys.argv[1:], flush=True)
print("got", signal.Signals(signal.sigwait(numbers)).name)
"""


@pytest.fixture
def prefix(tmp_path: Path) -> Path:
    """Return an ament prefix (in a path with a space) whose package `toy` has the executable `node`."""
    root = tmp_path / "a prefix"
    index = root / "share/ament_index/resource_index/packages"
    folder = root / "lib/toy"
    for path in (index, folder):
        path.mkdir(parents=True)
    for package in ("toy", "toy_msgs"):
        (index / package).touch()
    (folder / "node").write_text(NODE)
    (folder / "node").chmod(0o755)
    (folder / "data.txt").touch()
    return root


def command(*arguments: str) -> list[str]:
    """Return the command line of the small ros2 on this interpreter."""
    return [sys.executable, "-I", "-S", str(ROS2), *arguments]


def ros2(prefix: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the small ros2 to its end."""
    env = os.environ | {"AMENT_PREFIX_PATH": f"{prefix}:/nowhere"}
    return subprocess.run(command(*arguments), env=env, capture_output=True, text=True, check=False)


def test_packages_and_their_executables_are_listed(prefix: Path):
    assert ros2(prefix, "pkg", "list").stdout == "toy\ntoy_msgs\n"
    assert ros2(prefix, "pkg", "executables").stdout == "toy node\n"
    assert ros2(prefix, "pkg", "executables", "toy").stdout == "toy node\n"
    assert ros2(prefix, "pkg", "executables", "toy_msgs").stdout == ""


def test_the_first_prefix_that_has_a_package_wins(prefix: Path, tmp_path: Path):
    marker = tmp_path / "overlay/share/ament_index/resource_index/packages/toy"
    marker.parent.mkdir(parents=True)
    marker.touch()
    overlaid = Path(f"{tmp_path / 'overlay'}:{prefix}")
    assert ros2(overlaid, "pkg", "executables", "toy").stdout == ""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("run", "tyo", "node"), "no package 'tyo'; near: toy"),
        (("run", "toy", "noed"), "no executable of toy 'noed'; near: node"),
        (("run", "toy"), "name an executable of toy: node"),
        (("pkg", "executables", "toi"), "no package 'toi'; near: toy"),
        (("topic", "list"), "cannot do 'topic list'"),
    ],
)
def test_a_wrong_name_gets_the_nearest_and_fails(prefix: Path, arguments: tuple[str, ...], message: str):
    done = ros2(prefix, *arguments)
    assert done.returncode == 1
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_an_executable_that_cannot_start_is_one_line(prefix: Path):
    (prefix / "lib/toy/node").write_text("#!/no/such/python\n")
    done = ros2(prefix, "run", "toy", "node")
    assert done.returncode == 1
    assert done.stderr == f"ros2 (small): cannot start {prefix}/lib/toy/node: No such file or directory\n"


def test_help_says_that_only_run_and_pkg_exist(prefix: Path):
    done = ros2(prefix, "--help")
    assert done.returncode == 0
    assert "nothing else" in done.stdout


def test_the_exit_code_is_the_nodes(prefix: Path):
    assert ros2(prefix, "run", "toy", "node", "exit", "7").returncode == 7


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_to_ros2_run_reaches_the_node_and_leaves_nothing(prefix: Path, number: signal.Signals):
    env = os.environ | {"AMENT_PREFIX_PATH": str(prefix)}
    line = command("run", "toy", "node", "--ros-args", "-p", "a:=1")
    with subprocess.Popen(line, env=env, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready --ros-args -p a:=1\n"
        process.send_signal(number)  # to this process only: the node is this process
        assert process.stdout.read() == f"got {number.name}\n"
    assert process.returncode == 0


def test_a_real_ros2_is_never_shadowed(tmp_path: Path):
    real = tmp_path / "ros2"
    real.write_text("#!/bin/sh\n")
    real.chmod(0o755)
    if not (ROOT / "install/local_setup.bash").exists():
        pytest.skip("this checkout is not set up: scripts/setup")
    env = os.environ | {"PATH": f"{os.environ['PATH']}:{tmp_path}"}
    env["PATH"] = ":".join(part for part in env["PATH"].split(":") if not part.startswith(str(ROOT)))
    done = subprocess.run(
        ["bash", "-c", f'source "{ROOT}/scripts/env.sh" && command -v ros2'],
        env=env,
        capture_output=True,
        text=True,
        check=False,
    )
    assert Path(done.stdout.strip()).parent != ROS2.parent
