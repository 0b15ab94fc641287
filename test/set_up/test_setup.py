"""scripts/setup: one clear line for each thing that a machine can lack, and nothing half done."""

import fcntl
import importlib.util
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from fresh_checkout import ROOT, Checkout

UNREACHABLE = {
    "PIP_CONFIG_FILE": "/dev/null",
    "PIP_INDEX_URL": "http://127.0.0.1:9/simple",  # the discard port: refused at once
    "PIP_EXTRA_INDEX_URL": "",
    "PIP_FIND_LINKS": "",
    "PIP_NO_CACHE_DIR": "1",
}

WITHOUT_BYTECODE = """
import sys
from pathlib import Path
import q2q_control.ros.pid_node, q2q_sim.ros.stack, q2q_sim.tools.fly_scenario
specs = {name: getattr(module, "__spec__", None) for name, module in sys.modules.items()}
print(*(name for name, spec in specs.items() if spec and spec.cached and not Path(spec.cached).exists()))
"""


def error_line(stderr: str) -> str:
    """Return the one error line of a set-up that failed."""
    errors = [line for line in stderr.splitlines() if line.startswith("setup: error:")]
    assert len(errors) == 1, f"one error line is promised, and there are {len(errors)}:\n{stderr}"
    return errors[0]


def python_problem() -> Callable[[], str]:
    """Return `reason` of the script that judges an interpreter."""
    path = ROOT / "scripts/setup.d/python_is_usable.py"
    spec = importlib.util.spec_from_file_location("python_is_usable", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.reason


def test_help_shows_an_example(checkout: Checkout):
    done = checkout.setup("--help")
    assert done.returncode == 0
    assert "scripts/setup --dev && source scripts/env.sh" in done.stdout


def test_an_unknown_argument_is_named(checkout: Checkout):
    done = checkout.setup("--fast")
    assert done.returncode == 1
    assert "unknown argument '--fast'" in error_line(done.stderr)


def test_a_checkout_of_another_user_is_left_alone(checkout: Checkout):
    kept = checkout.root / ".venv" / "kept"
    kept.parent.mkdir()
    kept.touch()
    without_rights = (
        "setpriv --bounding-set=-dac_override --inh-caps=-dac_override" if os.geteuid() == 0 else ""
    )
    done = checkout.shell(
        f"chmod 555 . && {without_rights} scripts/setup; status=$?; chmod 755 .; exit $status"
    )
    assert done.returncode == 1
    assert f"{checkout.root} cannot be written by" in error_line(done.stderr)
    assert kept.exists()


@pytest.mark.parametrize("name", ["höuse", "家"])
def test_a_path_that_ros_cannot_build_in_is_refused_at_once(checkout: Checkout, name: str):
    """Its messages failed to build, after everything had been fetched."""
    house = checkout.root.rename(checkout.root.parent / name)
    done = replace(checkout, root=house).setup(CC="no-such-compiler", LANG="C.UTF-8")
    assert f"{house} has letters outside ASCII" in error_line(done.stderr)
    assert not (house / "log").exists()


@pytest.mark.parametrize(("hidden", "language"), [(("cc",), "C"), (("c++",), "C++")])
def test_a_missing_compiler_gives_one_line_and_no_venv(checkout: Checkout, hidden: tuple[str], language: str):
    checkout.hide(*hidden)
    done = checkout.setup(CC="cc", CXX="c++")
    assert done.returncode == 1
    assert f"no {language} compiler" in error_line(done.stderr)
    assert "build-essential" in error_line(done.stderr)
    assert not (checkout.root / ".venv").exists()


def test_a_compiler_named_by_the_environment_must_exist(checkout: Checkout):
    done = checkout.setup(CC="no-such-compiler")
    assert "no C compiler (no-such-compiler)" in error_line(done.stderr)


def test_a_shim_that_does_not_run_is_passed_over_and_said(checkout: Checkout):
    checkout.hide("python3")
    checkout.tool("python3", "echo not installed >&2; exit 127")
    done = checkout.setup(CC="true", CXX="true")
    line = error_line(done.stderr)
    assert "no usable Python: python3 does not run" in line
    assert "Install Python 3.11 or 3.12" in line
    assert not (checkout.root / ".venv").exists()


@pytest.mark.parametrize("script", ["exit 127", None])
@pytest.mark.parametrize("command", ["scripts/setup", "scripts/site"])
def test_a_chosen_python_is_taken_or_refused(checkout: Checkout, command: str, script: str | None):
    """Another one was taken, silently."""
    if script:
        checkout.tool("chosen", script)
    chosen = str(checkout.bin / "chosen")
    done = checkout.shell(command, CC="true", CXX="true", Q2Q_PYTHON=chosen, **UNREACHABLE)
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert f"Q2Q_PYTHON: {chosen} does not run" in line
    assert "or unset Q2Q_PYTHON" in line
    assert not list(checkout.root.glob(".venv*"))


def test_an_old_python_is_refused_with_its_version(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "version_info", (3, 9, 2, "final", 0))
    assert python_problem()() == "is Python 3.9, not 3.11 or 3.12"


def test_a_python_without_venv_names_the_package_to_install(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "ensurepip", None)
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    assert python_problem()() == f"has no venv module: sudo apt install python{version}-venv"


def test_this_python_is_usable():
    assert python_problem()() == ""


def test_no_network_gives_one_line_and_removes_the_half_made_venv(checkout: Checkout):
    done = checkout.setup(CC="true", CXX="true", **UNREACHABLE)
    assert done.returncode == 1
    assert "no network" in error_line(done.stderr)
    assert "Check the connection" in error_line(done.stderr)
    assert not (checkout.root / ".venv").exists()
    steps = [line for line in (checkout.root / "log/setup.log").read_text().splitlines() if line[:3] == "== "]
    assert "-m venv" in steps[0]
    assert "pip_install" in steps[-1]


def test_a_second_argument_is_named(checkout: Checkout):
    done = checkout.setup("--dev", "--fast")
    assert done.returncode == 1
    assert "unknown argument '--fast'" in error_line(done.stderr)


def test_no_network_is_said_also_where_the_log_is_long(checkout: Checkout):
    log = checkout.root / "log/setup.log"
    log.parent.mkdir()
    log.write_text("== an earlier step\n" + "a line of its output\n" * 100_000)
    done = checkout.setup(CC="true", CXX="true", **UNREACHABLE)
    assert "no network" in error_line(done.stderr)


def test_env_returns_the_failure_and_leaves_the_callers_options(checkout: Checkout):
    checkout.hide("cc")
    script = 'set -u; source scripts/env.sh && echo came through; echo "status $? options $-"'
    done = checkout.shell(script, CC="cc")
    assert "came through" not in done.stdout
    assert "status 1 options huBc" in done.stdout
    assert "no C compiler" in error_line(done.stderr)


def test_an_interrupted_setup_removes_what_it_made(checkout: Checkout):
    started = checkout.root / "started"
    os.mkfifo(started)
    # Stands in for a slow `python -m venv`: makes the folder, says so, then waits for the signal.
    making = f'for last; do :; done; mkdir "$last"; echo >"{started}"; exec sleep 60'
    real = (checkout.bin / "python3").read_text().splitlines()[1]
    checkout.tool("fake", f'case "$*" in *"-m venv"*) {making} ;; esac\n{real}')
    python = checkout.bin / "python3"
    python.write_text(
        f'#!/bin/sh\ncase "$*" in *sys.executable*) echo "{checkout.bin}/fake" ;; *) {real} ;; esac\n'
    )
    command = [str(checkout.root / "scripts/setup")]
    env = checkout.env | {"CC": "true", "CXX": "true"}
    with subprocess.Popen(command, env=env, start_new_session=True, stderr=subprocess.PIPE) as setup:
        started.read_text()
        assert (checkout.root / ".venv").exists()
        os.killpg(setup.pid, signal.SIGINT)
        setup.wait()
    assert setup.returncode != 0
    assert not (checkout.root / ".venv").exists()


def test_a_second_setup_waits_for_the_first(checkout: Checkout):
    log = checkout.root / "log"
    log.mkdir()
    command = [str(checkout.root / "scripts/setup")]
    env = checkout.env | {"CC": "no-such-compiler"}
    with (log / "setup.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with subprocess.Popen(command, env=env, stderr=subprocess.PIPE, text=True) as setup:
            assert setup.stderr is not None
            assert "waiting for another scripts/setup" in setup.stderr.readline()
            fcntl.flock(lock, fcntl.LOCK_UN)
            assert "no C compiler" in setup.stderr.read()


def newest(folder: Path) -> int:
    """Return the newest change [ns] of the stamps that a set-up writes."""
    return max(path.stat().st_mtime_ns for path in folder.iterdir())


@pytest.mark.skipif(
    not (ROOT / ".venv/q2q").exists(), reason="this checkout has no .venv: scripts/setup --dev"
)
def test_a_second_run_does_nothing_and_says_nothing():
    env = {name: value for name, value in os.environ.items() if not name.startswith("_ROS_WHEELS")}
    command = [str(ROOT / "scripts/setup"), "--dev"]
    subprocess.run(command, env=env, check=True)
    before = newest(ROOT / ".venv/q2q")
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert newest(ROOT / ".venv/q2q") == before


def test_set_up_has_written_the_bytecode_of_what_nodes_import() -> None:
    """Also where PYTHONDONTWRITEBYTECODE is set: each start would compile a thousand modules."""
    done = subprocess.run(
        [sys.executable, "-B", "-c", WITHOUT_BYTECODE],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    assert done.stdout.split() == []
