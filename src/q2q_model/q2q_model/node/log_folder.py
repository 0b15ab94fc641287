"""Folder of ROS's own log files, for users without a home folder that can be written (services, containers).

rcl_logging takes ROS_LOG_DIR, else ROS_HOME/log, else HOME/.ros/log; if it cannot make that, ROS does not
start.
"""

import os
import tempfile
from collections.abc import Mapping, MutableMapping
from contextlib import suppress
from pathlib import Path

CHOSEN = {"ROS_LOG_DIR": "", "ROS_HOME": "log", "HOME": ".ros/log"}
"""Environment variables of a folder, the first that is set counts, each with the path of the logs in it."""


def provide_log_folder(environment: MutableMapping[str, str]) -> None:
    """Let ROS log in a temporary folder of the user if an environment names none that can be written."""
    chosen = _chosen(environment)
    if chosen is None or not _is_writable(chosen):
        environment["ROS_LOG_DIR"] = str(_temporary())


def _chosen(environment: Mapping[str, str]) -> Path | None:
    """Return the folder that ROS would take."""
    for name, logs in CHOSEN.items():
        if given := environment.get(name):
            if given.startswith("~"):
                given = environment.get("HOME", "") + given.removeprefix("~")
            return Path(given, logs)
    return None


def _is_writable(folder: Path) -> bool:
    """Make a folder if it is missing; return whether this user can write it."""
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return os.access(folder, os.W_OK | os.X_OK)


def _temporary() -> Path:
    """Return the user's own temporary folder: a new one if its name is taken by another user."""
    own = Path(tempfile.gettempdir(), f"ros_log_{os.getuid()}")
    with suppress(OSError):
        own.mkdir(mode=0o700, exist_ok=True)
        if own.lstat().st_uid == os.getuid() and _is_writable(own):
            return own
    return Path(tempfile.mkdtemp(prefix=f"{own.name}_"))
