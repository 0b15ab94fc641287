"""Start of nodes as forks of one process that has imported and run their code once.

    this process --starts--> fork server (q2q_sim.ros.fork_server_preload) --forks--> node, node, ...

The fork server, of Python's multiprocessing, is a separate process that never initialises ROS, so that it has
no middleware threads, which would not survive a fork. It ends with this process, and the nodes with it.
"""

import os
import signal
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import forkserver, get_context
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import TracebackType

from q2q_sim.processes.parent_death import live_with

PRELOADED = "q2q_sim.ros.fork_server_preload"
"""Module that the fork server imports."""
IMPORTER = os.getpid()
"""Process that imported this module: in a node, which is a fork, the fork server."""


@dataclass(frozen=True, slots=True)
class NodeStart:
    """q2q executable with its process settings."""

    package: str
    executable: str
    command: Sequence[str]
    """Its command line."""
    environment: Mapping[str, str]
    """Environment; variables read on import (NUMBA_CACHE_DIR) keep the fork server's values."""
    log: Path
    """File for its output."""
    cores: frozenset[int]
    """Allowed cores; empty is any."""


def start_fork_server() -> None:
    """Start the fork server unless it runs; it is ready some seconds later."""
    forkserver.set_forkserver_preload([PRELOADED])
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # inherited: only this process handles Ctrl-C
    try:
        forkserver.ensure_running()
    finally:
        signal.signal(signal.SIGINT, before)


def start_forked(start: NodeStart) -> BaseProcess:
    """Start a node and return its process."""
    start_fork_server()
    process = get_context("forkserver").Process(target=_become, args=(start,), daemon=True)
    process.start()
    return process


def say_in_a_line(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """Report an uncaught exception; in one line, where the process that asks for forks was killed meanwhile.

    The fork server's excepthook: what such a fork should become can no longer be read (EOFError).
    """
    if isinstance(error, EOFError):
        print("the flight was killed while this node was starting", file=sys.stderr)
    else:
        sys.__excepthook__(kind, error, trace)


def join_session(cores: frozenset[int]) -> None:
    """Make this process a session of its own on its cores that ends with the fork server.

    Raises:
        SystemExit: the fork server is already dead.
    """
    os.setsid()
    if cores:
        os.sched_setaffinity(0, cores)
    live_with(IMPORTER)


def _become(start: NodeStart) -> None:
    sys.excepthook = sys.__excepthook__
    join_session(start.cores)
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # the fork server ignores it
    with start.log.open("wb") as log:
        for stream in (1, 2):
            os.dup2(log.fileno(), stream)
    os.environ.clear()
    os.environ.update(start.environment)
    sys.argv = list(start.command)
    getattr(
        import_module(f"{start.package}.commands.{start.package.removeprefix('q2q_')}_nodes"),
        start.executable,
    )()
