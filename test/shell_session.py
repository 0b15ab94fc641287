"""Shell session that runs the commands of a document, one after the other.

The environment stays from one command to the next, as in a shell. A node runs on in the background, as in a
second window, until it is ended.
"""

import os
import signal
import subprocess
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from started_nodes import TIMEOUT_S, wait_until_spinning

COMMAND_TIMEOUT_S = 1800.0
"""The longest command of the documents takes 30 s on an idle machine."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Output and exit status of a program."""

    status: int
    output: str
    """Output and errors."""


class ShellSession:
    """Folder and environment of a shell, and the nodes started from it."""

    def __init__(self, folder: Path, environment: Mapping[str, str]) -> None:
        """Open the session in a folder."""
        self._folder = folder
        self._environment = dict(environment)
        self._nodes: dict[str, subprocess.Popen[str]] = {}

    @property
    def nodes(self) -> tuple[str, ...]:
        """Return the names of the nodes that were started and not ended."""
        return tuple(self._nodes)

    def run(self, line: str) -> Answer:
        """Return the answer of a command; variables that it exports remain set."""
        kept = self._folder / ".environment"
        script = f"{line}\nstatus=$?\nenv -0 >'{kept}'\nexit $status"
        shell = self._shell(script)
        try:
            output, _ = shell.communicate(timeout=COMMAND_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            os.killpg(shell.pid, signal.SIGKILL)
            raise
        pairs = [entry.partition("=") for entry in kept.read_text().split("\0") if entry]
        self._environment = {name: value for name, _, value in pairs}
        return Answer(shell.returncode, output)

    def start(self, name: str, line: str) -> None:
        """Start a node in the background."""
        self._nodes[name] = self._shell(f"exec {line}")

    def await_spinning(self, name: str) -> None:
        """Return once a node listens to signals, or has ended."""
        wait_until_spinning(self._nodes[name])

    def await_port(self, port: int) -> None:
        """Return once some node has bound a UDP port of this machine; fail where all nodes have ended."""
        bound = f":{port:04X} "
        while bound not in Path("/proc/net/udp").read_text():
            running = [one for one in self._nodes.values() if one.poll() is None]
            assert running, f"no node has bound UDP port {port}"
            with suppress(subprocess.TimeoutExpired):
                running[0].wait(0.02)

    def end(self, name: str) -> Answer:
        """End a node by SIGINT, as Ctrl-C does; return its answer."""
        process = self._nodes.pop(name)
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        try:
            output, _ = process.communicate(timeout=TIMEOUT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        return Answer(process.returncode, output)

    def close(self) -> None:
        """Kill the nodes that still run."""
        for process in self._nodes.values():
            process.kill()
            process.communicate()

    def _shell(self, script: str) -> subprocess.Popen[str]:
        """Return a shell that runs a script, in a process group of its own."""
        return subprocess.Popen(
            ["bash", "-c", script],
            cwd=self._folder,
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            text=True,
            process_group=0,
        )
