"""Processes of a flight's nodes: start, supervision and end; none outlives its parent."""

import os
import signal
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from pathlib import Path
from time import monotonic
from typing import Self

import yaml

from q2q_model.tunable import ParameterValue
from q2q_sim.processes.fork_server import NodeStart, start_forked

END_TIMEOUT_S = 60.0
"""Time from the first SIGINT to SIGKILL [s]: a recorder of a busy machine writes what it still has."""
AGAIN_S = 10.0
"""Time after which SIGINT is sent again [s]: a node that is just being forked ignores it."""


@dataclass(frozen=True, slots=True)
class NodeSpec:
    """Executable and parameters of a node."""

    package: str
    executable: str
    parameters: Mapping[str, ParameterValue]
    cores: frozenset[int] = frozenset()
    """Allowed cores; empty is any, within a flight those of `cores_of`."""
    inside: tuple["NodeSpec", ...] = ()
    """Nodes within its process."""
    name: str = ""
    """Name of the node; empty is that of the executable."""

    @property
    def label(self) -> str:
        """Return the name of the node, its log and its parameter file."""
        return self.name or self.executable

    @property
    def nodes(self) -> tuple[str, ...]:
        """Return the names of all nodes of the process."""
        return (self.label, *(spec.label for spec in self.inside))


class NodeDiedError(ChildProcessError):
    """Node that ended before its flight, with its last output."""


def find_executable(package: str, executable: str) -> Path:
    """Return an installed executable; raise FileNotFoundError with the remedy."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        found = Path(prefix) / "lib" / package / executable
        if found.is_file():
            return found
    raise FileNotFoundError(
        f"{package} {executable} is not installed in this shell: run `source scripts/env.sh` first"
    )


class Processes:
    """Running nodes; a context manager that ends them all."""

    def __init__(self, folder: Path, environment: Mapping[str, str] | None = None) -> None:
        """Take the folder for parameter files and logs, and additions to the nodes' environment."""
        self._folder = folder
        self._environment = environment or {}
        self._running: dict[str, BaseProcess] = {}
        self._may_exit: set[str] = set()

    def __enter__(self) -> Self:
        """Return the set of processes."""
        return self

    def __exit__(self, *_: object) -> None:
        """Send SIGINT to every node, wait, and kill those that remain."""
        for process in self._running.values():
            _interrupt(process)
        for process in self._running.values():
            _wait(process)
        self._running.clear()

    def start(self, spec: NodeSpec) -> None:
        """Start a node with its parameters; its output goes to `<label>.log`.

        Raises:
            NodeDiedError: the fork server was killed meanwhile, as by a signal to all processes of a flight.
        """
        parameters = self._folder / f"{spec.label}.yaml"
        parameters.write_text(yaml.safe_dump(parameter_sections(spec)))
        remapped = ("-r", f"__node:={spec.name}") if spec.name else ()
        self._log(spec.label).touch()  # a node that is killed at once never opens it
        start = NodeStart(
            package=spec.package,
            executable=spec.executable,
            command=(
                str(find_executable(spec.package, spec.executable)),
                "--ros-args",
                "--params-file",
                str(parameters),
                *remapped,
            ),
            environment={**os.environ, **self._environment},
            log=self._log(spec.label),
            cores=spec.cores,
        )
        try:
            self._running[spec.label] = start_forked(start)
        except (EOFError, ConnectionError) as error:
            raise NodeDiedError(
                f"{spec.label} did not start: the process that starts nodes was killed"
            ) from error

    @property
    def may_exit(self) -> frozenset[str]:
        """Return the nodes that may have ended."""
        return frozenset(self._may_exit)

    def expect_exit(self, executable: str) -> None:
        """Allow a node to end from now on."""
        self._may_exit.add(executable)

    def expect(self, executable: str) -> None:
        """Allow a node to end no longer."""
        self._may_exit.discard(executable)

    def pid(self, executable: str) -> int:
        """Return a node's process id."""
        pid = self._running[executable].pid
        if pid is None:
            raise ValueError(f"{executable} has not started")
        return pid

    def check(self) -> None:
        """Raise NodeDiedError if a node has ended that was not expected to."""
        for name, process in self._running.items():
            if name not in self._may_exit and process.exitcode is not None:
                output = self._last_output(name)
                raise NodeDiedError(f"{name} ended with status {process.exitcode}: {output}")

    def _log(self, name: str) -> Path:
        return self._folder / f"{name}.log"

    def _last_output(self, name: str) -> str:
        lines = [line for line in self._log(name).read_text(errors="replace").splitlines() if line.strip()]
        return lines[-1] if lines else "no output"


def parameter_sections(spec: NodeSpec) -> dict[str, object]:
    """Return the parameter file of a process: one section, or one for each of its nodes."""
    if not spec.inside:
        return {"/**": {"ros__parameters": _nested(plain_values(spec.parameters))}}
    return {
        f"/**/{one.executable}": {"ros__parameters": _nested(plain_values(one.parameters))}
        for one in (spec, *spec.inside)
    }


def plain_values(parameters: Mapping[str, ParameterValue]) -> dict[str, object]:
    """Return plain values for YAML, without empty lists, whose type ROS cannot infer."""
    lists = {key: list(value) if isinstance(value, tuple) else value for key, value in parameters.items()}
    return {key: value for key, value in lists.items() if value != []}


def _nested(flat: Mapping[str, object]) -> dict[str, object]:
    """Return parameters named `a.b` as {a: {b: ...}}, the form of parameter files."""
    made: dict[str, object] = {key: value for key, value in flat.items() if "." not in key}
    for group in dict.fromkeys(key.partition(".")[0] for key in flat if "." in key):
        prefix = f"{group}."
        made[group] = {
            key.removeprefix(prefix): value for key, value in flat.items() if key.startswith(prefix)
        }
    return made


def _interrupt(process: BaseProcess) -> None:
    if process.exitcode is None and process.pid is not None:
        with suppress(ProcessLookupError):  # it has ended since
            os.kill(process.pid, signal.SIGINT)


def _wait(process: BaseProcess) -> None:
    deadline = monotonic() + END_TIMEOUT_S
    while process.exitcode is None and monotonic() < deadline:
        process.join(AGAIN_S)
        _interrupt(process)
    if process.exitcode is None:
        process.kill()
        process.join()
