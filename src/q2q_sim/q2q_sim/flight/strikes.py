"""Fly a scenario through the nodes and strike some of them: kill, or stop; let them come back, or not.

    kill       SIGKILL: it is gone without a word; come back: started anew, to take its place in flight
    stop       SIGSTOP: it stands still; come back: SIGCONT

In lockstep the simulator waits for its tick with the patience given (q2q_sim.loop.lockstep), so that a node
which comes back in time costs no tick; live, nothing waits.
"""

import os
import signal
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from q2q_sim.flight.running_nodes import running_nodes
from q2q_sim.flight.scenario_flight import FlightRequest, load_scenario, node_specs
from q2q_sim.loop.flight_clock import FlightTiming, timing_of
from q2q_sim.processes.processes import NodeSpec, Processes

LOOKS = 20
"""Looks of the flight director (50 ms each) from a strike to the coming back."""


@dataclass(frozen=True, slots=True)
class Strike:
    """What happens to which node, and when."""

    node: str
    tick: int
    """Once the flight has come to this tick, and nodes that were struck before are back."""
    how: Literal["kill", "stop"] = "kill"
    comes_back: bool = True


@dataclass(frozen=True, slots=True)
class Waiting:
    """Patience of the simulator in lockstep."""

    again_s: float = 0.2
    give_up_s: float = 60.0


def fly_struck(
    request: FlightRequest, strikes: Sequence[Strike], folder: Path, waiting: Waiting | None = None
) -> FlightTiming:
    """Fly a scenario into `folder`/bag, striking nodes; return how it went in wall time.

    Raises:
        ValueError: an unknown scenario, no such node in the flight, or no such tick.
        NodeDiedError, TimeoutError: another node ended early, or the flight stood still.
    """
    scenario = load_scenario(request)
    folder.mkdir(parents=True, exist_ok=True)
    specs = [
        _patient(spec, waiting or Waiting()) for spec in node_specs(scenario, request, folder, folder / "bag")
    ]
    known = {spec.executable: spec for spec in specs}
    for strike in strikes:
        if strike.node not in known:
            raise ValueError(f"no node {strike.node!r} in this flight; there are {', '.join(known)}")
    with running_nodes(specs, folder) as running:
        hands = [_Hand(running.processes, known[strike.node], strike) for strike in strikes]
        running.director.follow_clock()
        running.director.start()
        summary = running.director.wait_summary(lambda ticks: _look(hands, ticks))
    if not all(hand.done for hand in hands):
        raise ValueError("the flight ended before every node was struck and back: strike earlier")
    return timing_of(summary)


def _look(hands: Sequence["_Hand"], ticks: int) -> None:
    """Let the first of the hands look that is not done."""
    for hand in hands:
        if not hand.done:
            hand.look(ticks)
            return


class _Hand:
    """What a strike has come to."""

    def __init__(self, processes: Processes, spec: NodeSpec, strike: Strike) -> None:
        self._processes, self._spec, self._strike = processes, spec, strike
        self._looks = -1
        """Since the strike; below 0: it has not fallen."""

    @property
    def done(self) -> bool:
        """Return whether the strike has fallen, and the node is back if it comes back."""
        return self._looks >= (LOOKS if self._strike.comes_back else 0)

    def look(self, ticks: int) -> None:
        """Strike once the flight has come to the tick, and let the node come back some looks later."""
        if self._looks < 0 and ticks < self._strike.tick:
            return
        self._looks += 1
        if self._looks == 0:
            self._processes.excuse(self._spec.executable)
            self._send(signal.SIGKILL if self._strike.how == "kill" else signal.SIGSTOP)
        elif self._looks == LOOKS:
            self._come_back()

    def _come_back(self) -> None:
        self._processes.expect(self._spec.executable)
        if self._strike.how == "kill":
            self._processes.start(self._spec)
        else:
            self._send(signal.SIGCONT)

    def _send(self, number: signal.Signals) -> None:
        os.kill(self._processes.pid(self._spec.executable), number)


def _patient(spec: NodeSpec, waiting: Waiting) -> NodeSpec:
    if spec.executable != "simulator":
        return spec
    patience = {"again_s": waiting.again_s, "give_up_s": waiting.give_up_s}
    return replace(spec, parameters={**spec.parameters, **patience})
