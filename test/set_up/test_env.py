"""scripts/env.sh: the shell that it makes of shells of all kinds, and what is run in one."""

import os
import sys
from pathlib import Path

import pytest
from fresh_checkout import ROOT, Checkout

SOURCES = os.pathsep.join(map(str, sorted((ROOT / "src").iterdir())))


def test_a_folder_on_cdpath_is_not_taken_for_the_checkout(checkout: Checkout) -> None:
    (checkout.root.parent / "other/scripts").mkdir(parents=True)
    for cdpath in ("../other", ".:../other"):
        done = checkout.shell("source scripts/env.sh", CDPATH=cdpath, CC="no-such-compiler")
        assert "setup: error: no C compiler" in done.stderr


def made_on(checkout: Checkout, origin: str) -> Path:
    """Let a checkout look as if it had been set up; return its .venv."""
    (checkout.root / "scripts/setup").write_text("#!/bin/sh\n")
    stamps = checkout.root / ".venv/q2q"
    stamps.mkdir(parents=True)
    (stamps / "origin").write_text(f"{origin} 3.12\n")
    (stamps / "library_path").write_text("/opt/ros/jazzy/lib:/opt/ros/jazzy/lib/x86_64-linux-gnu")
    (checkout.root / "install").mkdir()
    for shell in ("bash", "zsh"):
        (checkout.root / f"install/local_setup.{shell}").touch()
    return stamps.parent


def entered(checkout: Checkout, name: str, **environment: str) -> str:
    """Return the value of a variable in the shell that env.sh makes of one with an environment."""
    done = checkout.shell(f'set -eu; source scripts/env.sh && printf %s "${name}"', **environment)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_libraries_of_an_overlay_that_was_sourced_after_the_set_up_are_kept(checkout: Checkout) -> None:
    made_on(checkout, "sourced")
    overlay = "/home/me/ws/install/crazyflie_interfaces/lib:/opt/ros/jazzy/lib"
    expected = overlay + ":/opt/ros/jazzy/lib/x86_64-linux-gnu"
    assert entered(checkout, "LD_LIBRARY_PATH", LD_LIBRARY_PATH=overlay) == expected
    assert entered(checkout, "LD_LIBRARY_PATH") == expected.partition(":")[2]


def test_on_wheels_the_libraries_of_another_ros_are_left_out_and_others_kept(checkout: Checkout) -> None:
    """Which of two libraries of a name was loaded was drawn again at each start: half of them failed."""
    made_on(checkout, "wheels")
    humble = {"AMENT_PREFIX_PATH": "/home/me/ws/install/other:/opt/ros/humble"}
    libraries = "/opt/ros/humble/lib:/opt/cuda/lib:/home/me/ws/install/other/lib:/opt/ros/humble/lib/x86"
    assert entered(checkout, "LD_LIBRARY_PATH", LD_LIBRARY_PATH=libraries, **humble) == "/opt/cuda/lib"
    assert entered(checkout, "LD_LIBRARY_PATH", LD_LIBRARY_PATH="/opt/cuda/lib") == "/opt/cuda/lib"
    assert entered(checkout, "LD_LIBRARY_PATH", **humble) == ""


def test_on_wheels_another_middleware_is_left_out_and_on_a_sourced_ros_kept(checkout: Checkout) -> None:
    """The wheels have Fast DDS only, and nodes do not start with another."""
    chosen = {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}
    stamps = made_on(checkout, "wheels") / "q2q"
    assert entered(checkout, "{RMW_IMPLEMENTATION:-}", **chosen) == ""
    (stamps / "origin").write_text("sourced 3.12\n")
    assert entered(checkout, "{RMW_IMPLEMENTATION:-}", **chosen) == "rmw_cyclonedds_cpp"


def test_on_wheels_the_home_of_another_python_is_left_out(checkout: Checkout) -> None:
    made_on(checkout, "wheels")
    assert entered(checkout, "{PYTHONHOME:-}", PYTHONHOME="/opt/other") == ""


def test_what_another_checkout_set_is_no_choice_of_the_user(checkout: Checkout) -> None:
    made_on(checkout, "wheels")
    other = checkout.root.parent / "other"
    (other / ".venv/q2q").mkdir(parents=True)
    for name, folder in {"NUMBA_CACHE_DIR": "build/numba", "Q2Q_DATA": "../shared/data"}.items():
        own = f"{checkout.root}/{folder}"
        assert entered(checkout, name) == own
        assert entered(checkout, name, **{name: own}) == own
        assert entered(checkout, name, **{name: f"{other}/{folder}"}) == own
        assert entered(checkout, name, **{name: "/home/me/chosen"}) == "/home/me/chosen"


def test_a_folder_of_machine_code_is_the_same_in_every_folder(checkout: Checkout) -> None:
    """Nodes that ran in another one than the set-up found nothing there, and compiled in flight."""
    made_on(checkout, "wheels")
    assert entered(checkout, "NUMBA_CACHE_DIR", NUMBA_CACHE_DIR="chosen") == f"{checkout.root}/chosen"


@pytest.mark.parametrize("script", ["campaign", "demo", "fly", "licence", "node_pages", "paper", "secure"])
def test_a_file_that_has_the_name_of_a_module_is_not_run_by_a_script(checkout: Checkout, script: str) -> None:
    """A `numpy.py` in the current folder was imported in place of numpy."""
    made_on(checkout, "sourced")
    checkout.tool("python", f'exec "{sys.executable}" "$@"')
    (checkout.root / "argparse.py").write_text("raise SystemExit('run')\n")
    done = checkout.shell(f"scripts/{script} --sede 3", PYTHONPATH=SOURCES)
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith(f"{script}: ")
