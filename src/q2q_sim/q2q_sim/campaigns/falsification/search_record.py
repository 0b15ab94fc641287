"""Record of a guided search, and the case file and replay page of what it found."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from q2q_sim.campaigns.falsification.candidate_flight import fly_candidate
from q2q_sim.campaigns.falsification.counterexample import case_of, shrink, write_case
from q2q_sim.campaigns.falsification.guided_search import SEARCH, guided_search
from q2q_sim.campaigns.random_runs.campaign_flight import fly_pure
from q2q_sim.campaigns.random_runs.random_run import Run
from q2q_sim.campaigns.random_runs.run_outcome import CRASH
from q2q_sim.campaigns.random_runs.violation_replay import write_replay
from q2q_sim.monitors.policies import Violation


@dataclass(frozen=True, slots=True)
class SearchRecord:
    """Record of a guided search."""

    seed: int
    length: int
    """Runs that it might take."""
    runs: int
    """Runs that it took."""
    policies: tuple[str, ...]
    """Policies that its case violates."""
    case: str
    """Path of the case file; empty without a violation."""
    seconds: float
    air: str = ""
    """Air named for the campaign; empty for that of the scenario."""
    thrust_exceeded: int = 0
    """Runs in which the thrust of some vehicle was exceeded: not judged by all policies."""
    unpredicted_downwash: int = 0
    """Runs in which one was lost in a downwash that nothing could predict: nor are they."""
    search: str = ""
    """SEARCH of the module guided_search."""


def search_and_keep(seed: int, length: int, kept: Path, air: str) -> SearchRecord:
    """Fly a guided search; shrink the violation found, and write case file and replay page in `kept`."""
    began = perf_counter()
    found = guided_search(seed, length, fly_candidate, air)
    case, policies = "", tuple(sorted(found.policies))
    if found.violated is not None:

        def still(run: Run) -> bool:
            return bool(fly_candidate(run).policies & found.policies)

        small = shrink(found.violated, still)
        outcome, path = fly_candidate(small), kept / f"case_{seed}.yaml"
        policies = tuple(sorted(outcome.policies))
        write_case(case_of(small, policies), path)
        write_case_page(small, outcome.violations, path.with_suffix(".html"))
        case = str(path)
    seconds = perf_counter() - began
    thrust_exceeded, unpredicted_downwash = found.thrust_exceeded, found.unpredicted_downwash
    return SearchRecord(
        seed, length, found.runs, policies, case, seconds, air, thrust_exceeded, unpredicted_downwash, SEARCH
    )


def write_case_page(run: Run, violations: Sequence[Violation], file: Path) -> None:
    """Fly a run once more and write its replay page; nothing if it ended before it can be replayed."""
    write_replay(file, run.scenario, fly_pure(run).topics, violations)


def record_of_dead_process(seed: int) -> SearchRecord:
    """Return the record of a guided search whose process died."""
    return SearchRecord(seed, length=0, runs=0, policies=(CRASH,), case="", seconds=0.0)
