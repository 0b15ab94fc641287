"""Replay page of a run that violated a policy."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from q2q_model.documents.written_file import write_text
from q2q_model.flights.joined_flight import flight_from_signals
from q2q_model.signals.layout import Signal
from q2q_sim.faults.faults import Fault
from q2q_sim.monitors.policies import Violation
from q2q_sim.replay_page import ReplayEvent, in_air, replay_html, replay_run
from q2q_sim.scenarios.scenario import Scenario


def write_replay(
    file: Path,
    scenario: Scenario,
    topics: Mapping[str, Sequence[Signal]],
    violations: Sequence[Violation],
) -> None:
    """Write the replay of a run with its violations marked; none if it ended before it can be replayed.

    A page of that name of an earlier run goes.
    """
    file.unlink(missing_ok=True)
    try:
        flight = flight_from_signals(file.stem, topics).flight
        run = in_air(replay_run(flight, scenario.vehicle, scenario.name), scenario.air or scenario.wake)
        marked = tuple(
            ReplayEvent(one.t, f"{one.who}, {one.policy}") for one in violations if np.isfinite(one.t)
        )
        flown = replace(run, verdict=_verdict_text(violations, scenario.faults), events=marked)
        page = replay_html([flown], f"{scenario.name}: {scenario.description}")
    except ValueError:
        return
    write_text(page, file)


def _verdict_text(violations: Sequence[Violation], faults: Sequence[Fault]) -> str:
    """Return what was violated, and under which faults."""
    acting = f". Faults: {', '.join(map(str, faults))}" if faults else ""
    return "; ".join(map(str, violations)) + acting
