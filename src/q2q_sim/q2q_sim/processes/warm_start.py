"""Start nodes as forks of one process that has imported and rehearsed their code, so that it is done once.

    this process --starts--> warm parent (q2q_sim.ros.warm_parent) --forks--> node, node, ...

The warm parent is Python's fork server: a process of its own that never initialises ROS, so that it has no
threads of the middleware, which would not survive a fork. It dies with this process, and the nodes with it.
"""

import ctypes
import os
import signal
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import forkserver, get_context
from multiprocessing.process import BaseProcess
from pathlib import Path

PARENT = "q2q_sim.ros.warm_parent"
"""What the fork server imports."""
PR_SET_PDEATHSIG = 1
"""prctl option: signal to get when the parent dies (Linux)."""
IMPORTER = os.getpid()
"""Process that imported this module: in a node, which is a fork, its warm parent."""


@dataclass(frozen=True, slots=True)
class NodeStart:
    """Executable of the house, and how it is to run."""

    package: str
    executable: str
    command: Sequence[str]
    """What it finds as its own command line."""
    environment: Mapping[str, str]
    """What is read when code is imported (NUMBA_CACHE_DIR) stays as the warm parent found it."""
    log: Path
    """File for what it prints."""
    cores: frozenset[int] = frozenset()
    """Where it may run; empty is anywhere."""


def begin() -> None:
    """Let the warm parent start, if it has not; it is ready some seconds later."""
    forkserver.set_forkserver_preload([PARENT])
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # inherited: Ctrl-C is for this process to pass on
    try:
        forkserver.ensure_running()
    finally:
        signal.signal(signal.SIGINT, before)


def fork(start: NodeStart) -> BaseProcess:
    """Start a node; return its process once it has begun."""
    begin()
    process = get_context("forkserver").Process(target=_become, args=(start,), daemon=True)
    process.start()
    return process


def die_with_parent() -> None:
    """Have this process get SIGTERM when its parent dies."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def settle(cores: frozenset[int]) -> None:
    """Make this process a session of its own that dies with its warm parent and stays on its cores.

    Raises:
        SystemExit: the warm parent died before its death could be signalled.
    """
    os.setsid()
    if cores:
        os.sched_setaffinity(0, cores)
    die_with_parent()
    if os.getppid() != IMPORTER:
        sys.exit("the warm parent is gone")


def _become(start: NodeStart) -> None:
    settle(start.cores)
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
