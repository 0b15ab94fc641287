"""Worker process that flies one flight after another through the nodes, so that it starts only once.

If the process dies, its flight has failed, and the next one gets a new process. After RECYCLE flights it is
replaced in any case, which bounds memory leaks.
"""

import os
import warnings
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from pathlib import Path
from typing import Self

import yaml

from q2q_sim.processes.domain import own_domain
from q2q_sim.processes.processes import NodeDiedError, NodeSpec, parameter_sections
from q2q_sim.processes.worker_pool import worker_pool
from q2q_sim.simulator.flight_clock import FlightTiming

RECYCLE = 50
"""Flights after which the process is replaced."""


class FlightWorker:
    """Worker process of nodes; a context manager."""

    def __init__(self, log: Path) -> None:
        """Take the log file of the nodes."""
        self._log = log
        self._domain = own_domain()

    def __enter__(self) -> Self:
        """Start the process in a ROS domain of its own."""
        self._domain.__enter__()
        self._pool = self._made()
        return self

    def __exit__(self, *_: object) -> None:
        """End the process."""
        self._pool.shutdown()
        self._domain.__exit__(None, None, None)

    def fly(self, specs: Sequence[NodeSpec], folder: Path) -> FlightTiming:
        """Fly the stack of flight_nodes.node_specs, in lockstep; bag and parameters stay.

        Raises:
            NodeDiedError: the process ended.
            ValueError, TimeoutError: a node refused its parameters, or the flight stalled.
        """
        (stack,) = specs
        folder.mkdir(parents=True, exist_ok=True)
        parameters = folder / "stack.yaml"
        parameters.write_text(yaml.safe_dump(parameter_sections(stack)))
        try:
            return self._pool.submit(_fly, parameters).result()
        except BrokenProcessPool as died:
            self._pool.shutdown()
            self._pool = self._made()
            raise NodeDiedError(f"the process of the nodes ended: {died}") from died

    def _made(self) -> ProcessPoolExecutor:
        return worker_pool(1, partial(_redirect_output, self._log), RECYCLE)


def _redirect_output(log: Path) -> None:
    """Redirect the process's output streams, to which the nodes log, into a file."""
    with log.open("ab") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)


def _fly(parameters: Path) -> FlightTiming:
    from q2q_sim.ros.flight_in_process import fly_in_process

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # injected clock jumps are corrected with a warning
        return fly_in_process(parameters)
