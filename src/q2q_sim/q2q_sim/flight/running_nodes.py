"""Run the nodes of a flight or of a replay together: started, wired, watched, drained, ended.

    specs -> processes, each on its cores -> wired -> (the caller flies) -> drained -> ended

Who is excused (q2q_sim.processes.processes: struck, and not to come back) is not waited for at the end.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from q2q_sim.processes.cores import allowed_cores, beside_chain, cores_of
from q2q_sim.processes.dds_profile import profile_environment
from q2q_sim.processes.domain import own_domain
from q2q_sim.processes.processes import NodeSpec, Processes
from q2q_sim.ros.flight_director import FlightDirector

RECORDER = "bag_record"
WIRING_TIMEOUT_S = 600.0
"""How long all nodes together may take to start and find each other [s]: from an empty cache of compiled code
two idle cores need 60, busy ones a multiple. Whether a node has died is asked all the while."""


@dataclass(frozen=True, slots=True)
class RunningNodes:
    """Processes and their watcher."""

    processes: Processes
    director: FlightDirector


@contextmanager
def running_nodes(
    specs: Sequence[NodeSpec], folder: Path, meanwhile: Callable[[], None] = lambda: None
) -> Iterator[RunningNodes]:
    """Hold nodes that have found each other; leaving it takes in what they said, and ends them.

    Args:
        specs: the nodes; one of them is the recorder.
        folder: where parameters and logs go.
        meanwhile: called while they start.

    Raises:
        NodeDiedError, TimeoutError: a node did not start or ended early.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with own_domain() as domain:
        cores = allowed_cores()
        environment = profile_environment(folder, beside_chain(domain, cores))
        with Processes(folder, environment) as processes:
            for spec in specs:
                processes.start(replace(spec, cores=cores_of(spec.executable, domain, cores)))
            with FlightDirector(processes.check) as director:
                names = [name for spec in specs for name in spec.nodes]
                director.wait_wired(names, WIRING_TIMEOUT_S, meanwhile)
                yield RunningNodes(processes, director)
                director.wait_drained(_recorder_last(specs, processes.excused))


def _recorder_last(specs: Sequence[NodeSpec], excused: frozenset[str]) -> list[str]:
    there = [name for spec in specs if spec.executable not in excused for name in spec.nodes]
    return sorted(there, key=lambda name: name == RECORDER)
