"""ROS starts without a home folder that can be written."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from q2q_model.node.log_folder import CHOSEN, provide_log_folder


@pytest.mark.parametrize("name", CHOSEN)
def test_a_folder_that_is_named_is_kept(name: str, tmp_path: Path) -> None:
    environment = {name: str(tmp_path)}
    provide_log_folder(environment)
    assert environment == {name: str(tmp_path)}


def test_a_folder_in_the_home_folder_is_kept(tmp_path: Path) -> None:
    environment = {"HOME": str(tmp_path), "ROS_LOG_DIR": "~/logs"}
    provide_log_folder(environment)
    assert environment["ROS_LOG_DIR"] == "~/logs"
    assert (tmp_path / "logs").is_dir()


@pytest.mark.parametrize("home", [{}, {"HOME": ""}, {"HOME": "/proc"}])
def test_ros_starts_without_a_home_folder_that_can_be_written(home: dict[str, str]) -> None:
    """Nobody, root included, can make a folder in /proc."""
    environment = {key: value for key, value in os.environ.items() if key not in CHOSEN} | home
    start = "from q2q_model.ros.node.run import start_ros; start_ros([]); print('started')"
    done = subprocess.run(
        [sys.executable, "-c", start], capture_output=True, text=True, check=False, env=environment
    )
    assert (done.stdout, done.stderr) == ("started\n", "")


def test_the_temporary_folder_is_not_one_of_another_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    own, environment = tmp_path / f"ros_log_{os.getuid()}", {"HOME": "/proc"}
    provide_log_folder(environment)
    assert environment["ROS_LOG_DIR"] == str(own)
    assert own.stat().st_mode & 0o777 == 0o700
    other = os.getuid() + 1
    (taken := tmp_path / f"ros_log_{other}").mkdir()
    monkeypatch.setattr(os, "getuid", lambda: other)  # to whom the folder does not belong
    environment = {"HOME": "/proc"}
    provide_log_folder(environment)
    assert environment["ROS_LOG_DIR"].startswith(f"{taken}_")
    assert Path(environment["ROS_LOG_DIR"]).is_dir()
