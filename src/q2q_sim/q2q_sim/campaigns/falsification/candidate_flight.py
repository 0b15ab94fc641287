"""One run of a guided campaign: its violations, and the margins of policies and postconditions.

In addition to the policies, postconditions are checked, which the blocks state of their own output, and
which random campaigns leave to other tests: filter_properties, guard_properties, brake_property,
evasion_property, replanner_properties, and

| violation | statement that it breaks |
|---|---|
| record | frames and commands of the run, read back from a bag, are those that were written |
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from q2q_model.bag import BagReader, BagWriter
from q2q_model.signals.layout import Signal
from q2q_model.signals.rows import SignalRows, rows_of_signals
from q2q_model.signals.stamps import stamp_from_time
from q2q_sim.campaigns.falsification.postconditions import (
    filter_properties,
    guard_properties,
    replanner_properties,
)
from q2q_sim.campaigns.falsification.postconditions.brake_property import brake
from q2q_sim.campaigns.falsification.postconditions.evasion_property import evasion
from q2q_sim.campaigns.falsification.postconditions.postcondition_outcome import PostconditionOutcome
from q2q_sim.campaigns.falsification.postconditions.run_ticks import RunTicks, run_ticks
from q2q_sim.campaigns.random_runs.campaign_flight import circumstances_of, crash_violation, fly_pure
from q2q_sim.campaigns.random_runs.random_run import Run
from q2q_sim.monitors.policies import Violation
from q2q_sim.monitors.policies.exemptions.thrust_exceeded import thrust_exceeded
from q2q_sim.monitors.policies.exemptions.unpredicted_downwash import unpredicted_downwash
from q2q_sim.monitors.policies.margins import margins

RECORD = "record"
"""Name of the recorder's postcondition."""
POSTCONDITIONS: Mapping[str, Callable[[Run, RunTicks], PostconditionOutcome]] = {
    "lost_moving": filter_properties.lost_moving,
    "swap_moved_track": filter_properties.swap_moved_track,
    "stale_reported_ok": guard_properties.stale_reported_ok,
    "repeat_reported_ok": guard_properties.repeat_reported_ok,
    "hold_too_long": guard_properties.hold_too_long,
    "brake": brake,
    "evasion": evasion,
    "promise": replanner_properties.promise,
    "stop_enters_zone": replanner_properties.stop_enters_zone,
    "off_path_unreported": replanner_properties.off_path_unreported,
    "acc_held_too_long": replanner_properties.acc_held_too_long,
}
"""Postconditions by name."""
RECORDED = ("mocap", "command")
"""Topics of the bag that is read back: the first and the last of a tick."""
WORST = 1e3
"""Largest size of a margin, also that of a run that ends with an error [-]."""


@dataclass(frozen=True, slots=True)
class CandidateFlight:
    """Outcome of a run that a search proposes."""

    violations: tuple[Violation, ...]
    margins: Mapping[str, float] = field(default_factory=dict)
    """Margins of the policies and postconditions that have one, within WORST of 0 [-]."""
    thrust_exceeded: bool = False
    """Whether no command carried some vehicle at some time."""
    unpredicted_downwash: bool = False
    """Whether some vehicle was flown without measurements in a downwash that nothing could predict."""

    @property
    def policies(self) -> frozenset[str]:
        """Return the violated policies and postconditions."""
        return frozenset(one.policy for one in self.violations)


def fly_candidate(run: Run) -> CandidateFlight:
    """Return the outcome of a run by closed_loop; an error counts as a violation."""
    flown = fly_pure(run)
    if flown.trace is None:
        return CandidateFlight(flown.violations)
    ticks = run_ticks(flown.topics)
    outcomes = {name: judged(run, ticks) for name, judged in POSTCONDITIONS.items()}
    found = [one for outcome in outcomes.values() for one in outcome.violations]
    circumstances = circumstances_of(run)
    known = dict(margins(flown.trace, circumstances))
    known |= {name: outcome.margin for name, outcome in outcomes.items()}
    try:
        found += _record(flown.topics)
    except Exception as error:  # noqa: BLE001 - a campaign looks for any error
        found.append(crash_violation(error))
    return CandidateFlight(
        violations=(*flown.violations, *found),
        margins={name: bounded_margin(one) for name, one in known.items()},
        thrust_exceeded=bool(thrust_exceeded(flown.trace, circumstances).any()),
        unpredicted_downwash=bool(unpredicted_downwash(flown.trace, circumstances).any()),
    )


def bounded_margin(margin: float) -> float:
    """Return a margin within WORST of 0."""
    return min(max(margin, -WORST), WORST)


def _record(topics: Mapping[str, Sequence[Signal]]) -> Iterator[Violation]:
    """Yield a violation if the bag of the recorded topics, read back, has other messages."""
    written = {topic: topics[topic] for topic in RECORDED}
    with TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        with BagWriter(bag) as writer:
            for truth, *signals in zip(topics["truth"], *written.values(), strict=True):
                for topic, one in zip(RECORDED, signals, strict=True):
                    writer.write_signal(topic, stamp_from_time(truth.t), one)
        read = BagReader(bag).rows(RECORDED)
    for topic in RECORDED:
        if not _same(rows_of_signals(written[topic]), read[topic]):
            yield Violation(RECORD, topic, math.nan, math.nan, 0.0)
            return


def _same(written: Sequence[SignalRows], read: Sequence[SignalRows]) -> bool:
    """Return whether the messages of a topic have the same order, stamps, names and numbers."""
    back = {rows.names: rows for rows in read}
    return len(written) == len(read) and all(
        mine.names in back and _same_rows(mine, back[mine.names]) for mine in written
    )


def _same_rows(mine: SignalRows, back: SignalRows) -> bool:
    return (
        np.array_equal(mine.t, back.t)
        and np.array_equal(mine.place, back.place)
        and all(np.array_equal(own, back.values[name], equal_nan=True) for name, own in mine.values.items())
    )
