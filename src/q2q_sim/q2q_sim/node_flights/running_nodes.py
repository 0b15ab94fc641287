"""Running nodes of a flight or replay: started, connected, watched, drained, ended.

    specs -> processes, each on its cores -> connected -> (the caller flies) -> drained -> ended

Excused nodes (q2q_sim.processes.processes: killed or stopped for good) are not waited for at the end.
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
"""Time-out for starting and connecting all nodes [s]: with an empty kernel cache two idle cores need 60, busy
ones several times that. A node that dies meanwhile is noticed at once."""


@dataclass(frozen=True, slots=True)
class RunningNodes:
    """Processes and flight director of running nodes."""

    processes: Processes
    director: FlightDirector


@contextmanager
def running_nodes(
    specs: Sequence[NodeSpec],
    folder: Path,
    meanwhile: Callable[[Sequence[str]], None] = lambda _: None,
) -> Iterator[RunningNodes]:
    """Yield connected nodes; on exit drain their messages and end them.

    Args:
        specs: the nodes; one of them is the recorder. Those without cores get theirs.
        folder: output folder for parameters and logs.
        meanwhile: called while they start, with descriptions of the missing connections.

    Raises:
        NodeDiedError, TimeoutError: a node did not start or ended early.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with own_domain() as domain:
        cores = allowed_cores()
        environment = profile_environment(folder, beside_chain(domain, cores))
        with Processes(folder, environment) as processes:
            for spec in specs:
                own = spec.cores or cores_of(spec.executable, domain, cores)
                processes.start(replace(spec, cores=own))
            with FlightDirector(processes.check) as director:
                names = [name for spec in specs for name in spec.nodes]
                director.wait_connected(names, WIRING_TIMEOUT_S, meanwhile)
                yield RunningNodes(processes, director)
                director.wait_drained(_recorder_last(specs, processes.may_exit))


def _recorder_last(specs: Sequence[NodeSpec], may_exit: frozenset[str]) -> list[str]:
    there = [name for spec in specs if spec.executable not in may_exit for name in spec.nodes]
    return sorted(there, key=lambda name: name == RECORDER)
