"""One run of a guided campaign: its violations, and the margins of policies and stated properties.

Beside the policies, properties are checked that the blocks state of their own output, and which random
campaigns leave to other tests: filter_properties, guard_properties, replanner_properties, and

| property | statement |
|---|---|
| record | the bag of the run, read back, is the evidence of its signals |
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from q2q_model.bag import BagReader, BagWriter
from q2q_model.signals.stamps import time_from_stamp
from q2q_sim.experiments.campaign.campaign_flight import NS, at_own_stamps, crash, flown_pure
from q2q_sim.experiments.campaign.random_run import Run
from q2q_sim.experiments.campaign.run_outcome import CRASH
from q2q_sim.experiments.guided.stated_properties import (
    filter_properties,
    guard_properties,
    replanner_properties,
)
from q2q_sim.experiments.guided.stated_properties.run_ticks import RunTicks, run_ticks
from q2q_sim.experiments.guided.stated_properties.stated_outcome import StatedOutcome
from q2q_sim.monitors.policies import Circumstances, Evidence, RecordedSignal, Violation, evidence_of
from q2q_sim.monitors.policies.margins import margins

RECORD = "record"
"""Name of the recorder's property."""
PROPERTIES: Mapping[str, Callable[[Run, RunTicks], StatedOutcome]] = {
    "lost": filter_properties.lost,
    "swap": filter_properties.swap,
    "repeat": guard_properties.repeat,
    "hold": guard_properties.hold,
    "brake": guard_properties.brake,
    "evasion": guard_properties.evasion,
    "promise": replanner_properties.promise,
    "off_path": replanner_properties.off_path,
    "held_acc": replanner_properties.held_acc,
}
"""Stated properties by name."""
COMPARED = (
    "t", "true_pos", "sent_pos", "seen", "state_pos", "state_age", "state_status", "thrust", "roll",
    "pitch", "command_status", "true_downwash",
)  # fmt: skip
"""Evidence that a bag must give back."""
WORST = 1e3
"""Largest size of a margin, also that of a run that ends with an error [-]."""


@dataclass(frozen=True, slots=True)
class AttackedFlight:
    """Outcome of an attacked run."""

    violations: tuple[Violation, ...]
    margins: Mapping[str, float] = field(default_factory=dict)
    """Margins of the policies and properties that have one, within WORST of 0 [-]."""

    @property
    def policies(self) -> frozenset[str]:
        """Return the violated policies and properties."""
        return frozenset(one.policy for one in self.violations)


def fly_attacked(run: Run) -> AttackedFlight:
    """Return the outcome of a run by closed_loop; an error counts as a violation."""
    flown = flown_pure(run)
    if any(one.policy == CRASH for one in flown.violations):
        return AttackedFlight(flown.violations)
    evidence = evidence_of(at_own_stamps(flown.signals))
    ticks = run_ticks(flown.signals)
    stated = {name: judged(run, ticks) for name, judged in PROPERTIES.items()}
    found = [one for outcome in stated.values() for one in outcome.violations]
    scenario = run.scenario
    known = dict(margins(evidence, Circumstances(vehicle=scenario.vehicle, faults=scenario.faults)))
    known |= {name: outcome.margin for name, outcome in stated.items()}
    try:
        found += _record(evidence, flown.signals)
    except Exception as error:  # noqa: BLE001 - a campaign looks for any error
        found.append(crash(error))
    return AttackedFlight((*flown.violations, *found), {name: bounded(one) for name, one in known.items()})


def bounded(margin: float) -> float:
    """Return a margin within WORST of 0."""
    return min(max(margin, -WORST), WORST)


def _record(evidence: Evidence, signals: Sequence[RecordedSignal]) -> Iterator[Violation]:
    """Yield a violation if the bag of the signals, read back, gives other evidence."""
    with TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        with BagWriter(bag) as writer:
            for one in signals:
                writer.write_signal(one.topic, round(one.at * NS), one.signal)
        read = evidence_of(
            RecordedSignal(one.topic, time_from_stamp(one.stamp_ns), one.signal)
            for one in BagReader(bag).signals()
        )
    for column in COMPARED:
        here, there = getattr(evidence, column), getattr(read, column)
        if not np.array_equal(here, there, equal_nan=True):
            yield Violation(RECORD, column, math.nan, math.nan, 0.0)
            return
