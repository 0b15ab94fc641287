"""Counterexample: a run that violates a policy, shrunk to the fewest faults, kept as a case and flown again.

A case file is YAML: the fields of Counterexample. Shrinking removes faults one at a time, then rounds the
numbers of those that remain, and keeps each change after which one of the same policies is still violated.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import yaml

from q2q_model.documents.plain_values import from_plain
from q2q_model.documents.written_file import write_text
from q2q_model.documents.yaml_text import load_yaml
from q2q_sim.campaigns.random_runs.campaign_flight import plain_document
from q2q_sim.campaigns.random_runs.random_run import Run, fault_document
from q2q_sim.faults.drawn_faults import earliest_start
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.scenarios.scenario_document import scenario_from_document

DIGITS = (1, 2)
"""Decimals that times and sizes are rounded to, the coarsest first."""


@dataclass(frozen=True, slots=True)
class Counterexample:
    """Run that violates policies, as in its file."""

    seed: int
    violates: tuple[str, ...]
    """Policies that it violated when it was found."""
    options: BlockChoices
    scenario: Mapping[str, object]
    """Document of the scenario."""

    @property
    def run(self) -> Run:
        """Return the run."""
        return Run(self.seed, dict(self.scenario), self.options)


def with_faults(run: Run, faults: tuple[Fault, ...]) -> Run:
    """Return a run with other faults."""
    return replace(run, document={**run.document, "faults": [fault_document(fault) for fault in faults]})


def shrink(run: Run, still: Callable[[Run], bool]) -> Run:
    """Return a run with the fewest and roundest faults for which `still` holds, as it does for `run`."""
    smaller: Run | None = run
    while smaller is not None:
        run = smaller
        smaller = next((one for one in _with_one_less(run) if still(one)), None)
    for row in range(len(run.scenario.faults)):
        run = next((one for one in _rounded(run, row) if still(one)), run)
    return run


def _with_one_less(run: Run) -> Iterator[Run]:
    faults = run.scenario.faults
    for row in range(len(faults)):
        yield with_faults(run, (*faults[:row], *faults[row + 1 :]))


def _rounded(run: Run, row: int) -> Iterator[Run]:
    faults = run.scenario.faults
    for digits in DIGITS:
        one = faults[row]
        start, duration, size = (round(value, digits) for value in (one.start, one.duration, one.size))
        try:
            rounder = replace(one, start=max(start, earliest_start(one.kind)), duration=duration, size=size)
        except ValueError:  # a size rounded out of its bounds
            continue
        yield with_faults(run, (*faults[:row], rounder, *faults[row + 1 :]))


def case_of(run: Run, policies: Iterable[str]) -> Counterexample:
    """Return the case of a run that violates policies."""
    return Counterexample(run.seed, tuple(sorted(policies)), run.options, run.document)


def write_case(case: Counterexample, path: Path) -> None:
    """Write a case file."""
    write_text(yaml.safe_dump(plain_document(asdict(case)), sort_keys=False), path)


def read_case(path: Path) -> Counterexample:
    """Return the case in a file; raise ValueError for a file that cannot be read or is no case."""
    case = from_plain(Counterexample, load_yaml(path), str(path))
    scenario_from_document(str(path), case.scenario)
    return case
