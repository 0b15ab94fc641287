"""Folder of ROS's own log files, for users without a home folder (services, containers).

rcl_logging takes ROS_LOG_DIR, else ROS_HOME/log, else HOME/.ros/log; without any of them ROS does not start.
"""

import os
import tempfile
from collections.abc import MutableMapping
from pathlib import Path

CHOSEN = ("ROS_LOG_DIR", "ROS_HOME", "HOME")


def provide_log_folder(environment: MutableMapping[str, str]) -> None:
    """Let ROS log in a temporary folder of the user if an environment names none."""
    if not any(map(environment.get, CHOSEN)):
        environment["ROS_LOG_DIR"] = str(Path(tempfile.gettempdir()) / f"ros_log_{os.getuid()}")
