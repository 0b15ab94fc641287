"""ROS starts without a home folder."""

import os
import subprocess
import sys

import pytest

from q2q_model.node.log_folder import CHOSEN, provide_log_folder


@pytest.mark.parametrize("name", CHOSEN)
def test_a_folder_that_is_named_is_kept(name: str) -> None:
    environment = {name: "/somewhere"}
    provide_log_folder(environment)
    assert environment == {name: "/somewhere"}


@pytest.mark.parametrize("empty", [{}, {"HOME": ""}])
def test_ros_starts_without_a_home_folder(empty: dict[str, str]) -> None:
    environment = {key: value for key, value in os.environ.items() if key not in CHOSEN} | empty
    start = "from q2q_model.ros.node.run import start_ros; start_ros([]); print('started')"
    done = subprocess.run(
        [sys.executable, "-c", start], capture_output=True, text=True, check=False, env=environment
    )
    assert (done.stdout, done.stderr) == ("started\n", "")
