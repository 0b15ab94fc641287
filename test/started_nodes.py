"""Start nodes as a user does, and know when they listen to signals."""

import os
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path

from q2q_sim.processes.processes import find_executable

TIMEOUT_S = 60.0


def start(
    package: str, executable: str, words: Sequence[str], folder: Path | None = None
) -> subprocess.Popen[str]:
    """Start a node with the words that follow its name."""
    return subprocess.Popen(
        [str(find_executable(package, executable)), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        env=os.environ | {"RCUTILS_LOGGING_BUFFERED_STREAM": "0"},
    )


def wait_until_spinning(process: subprocess.Popen[str]) -> None:
    """Return once the process catches SIGINT and SIGTERM with its middleware running, or has ended."""
    status = Path(f"/proc/{process.pid}/status")
    expected = 1 << (signal.SIGINT - 1) | 1 << (signal.SIGTERM - 1)
    while process.poll() is None:
        line = next(line for line in status.read_text().splitlines() if line.startswith("SigCgt"))
        if int(line.split()[1], 16) & expected == expected and _threads_of_dds(process.pid):
            return
        try:
            process.wait(0.02)
        except subprocess.TimeoutExpired:
            continue


def _threads_of_dds(pid: int) -> bool:
    """Return whether Fast DDS runs threads in a process: then its imports are over."""
    names = Path(f"/proc/{pid}/task").glob("*/comm")
    return any(map(_is_of_dds, names))


def _is_of_dds(name: Path) -> bool:
    try:
        return name.read_text().startswith("dds.")
    except OSError:  # the thread has ended
        return False
