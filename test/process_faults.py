"""Process faults: flight of a scenario in which nodes are killed, stopped or hang, and perhaps come back.

    kill       SIGKILL; come back: restarted in flight
    stop       SIGSTOP; come back: SIGCONT
    hang       the threads of the middleware stand still, those of the node run; come back: they go on

In lockstep the simulator waits for its tick with the given time-outs (q2q_sim.simulator.resend_timer): a node
which returns in time costs no tick; in live flight nothing waits.
"""

import os
import signal
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from frozen_threads import FrozenThreads

from q2q_sim.node_flights.flight_nodes import node_specs
from q2q_sim.node_flights.flight_request import FlightRequest, load_scenario
from q2q_sim.node_flights.running_nodes import running_nodes
from q2q_sim.processes.processes import NodeSpec, Processes
from q2q_sim.simulator.flight_clock import FlightTiming

MIDDLEWARE = "dds."
"""Names of Fast DDS's threads begin so: receivers, events, asynchronous writer."""
POLLS = 20
"""Polls of the flight director (50 ms each) from a fault to the return."""


@dataclass(frozen=True, slots=True)
class ProcessFault:
    """Fault of one node's process."""

    node: str
    tick: int
    """First tick of the fault; earlier faults must be over."""
    how: Literal["kill", "stop", "hang"] = "kill"
    comes_back: bool = True


@dataclass(frozen=True, slots=True)
class Waiting:
    """Time-outs of the simulator in lockstep."""

    resend_period_s: float = 0.2
    command_timeout_s: float = 60.0


def fly_with_process_faults(
    request: FlightRequest, faults: Sequence[ProcessFault], folder: Path, waiting: Waiting | None = None
) -> FlightTiming:
    """Fly a scenario into `folder`/bag with faults; return its wall-clock timing.

    Raises:
        ValueError: an unknown scenario, node or tick.
        NodeDiedError, TimeoutError: another node ended early, or the flight stalled.
    """
    scenario = load_scenario(request)
    folder.mkdir(parents=True, exist_ok=True)
    specs = [
        _patient(spec, waiting or Waiting()) for spec in node_specs(scenario, request, folder, folder / "bag")
    ]
    known = {spec.executable: spec for spec in specs}
    for fault in faults:
        if fault.node not in known:
            raise ValueError(f"no node {fault.node!r} in this flight; there are {', '.join(known)}")
    with running_nodes(specs, folder) as running:
        progresses = [_Progress(running.processes, known[fault.node], fault) for fault in faults]
        running.director.follow_clock()
        running.director.start()
        try:
            timing = running.director.wait_summary(lambda ticks: _poll(progresses, ticks))
        finally:
            for one in progresses:
                one.release()
    if not all(one.done for one in progresses):
        raise ValueError("the flight ended before every fault was over: let them begin earlier")
    return timing


def _poll(progresses: Sequence["_Progress"], ticks: int) -> None:
    """Advance the first fault that is not over."""
    for one in progresses:
        if not one.done:
            one.poll(ticks)
            return


class _Progress:
    """Progress of a fault."""

    def __init__(self, processes: Processes, spec: NodeSpec, fault: ProcessFault) -> None:
        self._processes, self._spec, self._fault = processes, spec, fault
        self._frozen: FrozenThreads | None = None
        self._polls = -1
        """Polls since the fault began; below 0 before it."""

    @property
    def done(self) -> bool:
        """Return whether the fault is over, including the return of the node."""
        return self._polls >= (POLLS if self._fault.comes_back else 0)

    def poll(self, ticks: int) -> None:
        """Begin the fault at its tick, and bring the node back some polls later."""
        if self._polls < 0 and ticks < self._fault.tick:
            return
        self._polls += 1
        if self._polls == 0:
            self._begin()
        elif self._polls == POLLS:
            self._come_back()

    def _begin(self) -> None:
        if self._fault.how == "hang":
            self._frozen = FrozenThreads(self._processes.pid(self._spec.executable), MIDDLEWARE)
            return
        self._processes.expect_exit(self._spec.executable)
        self._send(signal.SIGKILL if self._fault.how == "kill" else signal.SIGSTOP)

    def release(self) -> None:
        """Let frozen threads go on: a process with one cannot end."""
        if self._frozen is not None:
            self._frozen.release()

    def _come_back(self) -> None:
        if self._fault.how == "hang":
            self.release()
            return
        self._processes.expect(self._spec.executable)
        if self._fault.how == "kill":
            self._processes.start(self._spec)
        else:
            self._send(signal.SIGCONT)

    def _send(self, number: signal.Signals) -> None:
        os.kill(self._processes.pid(self._spec.executable), number)


def _patient(spec: NodeSpec, waiting: Waiting) -> NodeSpec:
    if spec.executable != "simulator":
        return spec
    timeouts = {"resend_period_s": waiting.resend_period_s, "command_timeout_s": waiting.command_timeout_s}
    return replace(spec, parameters={**spec.parameters, **timeouts})
