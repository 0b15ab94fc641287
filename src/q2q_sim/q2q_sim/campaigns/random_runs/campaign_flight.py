"""One run of a campaign by closed_loop, checked against the policies; a violation keeps bag and replay."""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from time import perf_counter

import numpy as np
import yaml

from q2q_model.bag import BagWriter
from q2q_model.documents.written_file import write_text
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.layout import Signal
from q2q_model.signals.stamps import stamp_from_time
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run
from q2q_sim.campaigns.random_runs.run_outcome import CRASH, RunOutcome
from q2q_sim.campaigns.random_runs.violation_replay import write_replay
from q2q_sim.flight_bag.scenario_facts import scenario_facts
from q2q_sim.loop.closed_loop import FlightOptions, answered_ticks
from q2q_sim.loop.flight_blocks import MODES
from q2q_sim.monitors.policies import (
    Circumstances,
    FlightTrace,
    RecordedSignal,
    Violation,
    judge,
    trace_in_lockstep,
)

JUDGED = ("truth", "truth_interference", "mocap", "state", "reference_safe", "command")
"""Topics by which the policies judge a run, and those of its bag."""


@dataclass(frozen=True, slots=True)
class JudgedFlight:
    """Measurements and violations of a run's flight."""

    topics: Mapping[str, Sequence[Signal]]
    """Signals of every tick, by topic: JUDGED."""
    violations: tuple[Violation, ...]
    trace: FlightTrace | None = None
    """None where the flight ended with an error."""

    @property
    def signals(self) -> tuple[RecordedSignal, ...]:
        """Return the signals, tick by tick, each recorded at the true time of its tick."""
        ticks = zip(*(self.topics[topic] for topic in JUDGED), strict=True)
        timed = ((ticked[0].t, zip(JUDGED, ticked, strict=True)) for ticked in ticks)
        return tuple(RecordedSignal(topic, at, one) for at, ticked in timed for topic, one in ticked)


def fly_and_judge(seed: int, kept: Path, air: str = "") -> RunOutcome:
    """Fly the run of a seed by closed_loop and check it; a violation leaves its files in `kept`."""
    began = perf_counter()
    run = draw_run(seed, air)
    flown = fly_pure(run)
    if flown.violations:
        keep_run(run, flown.signals, kept)
        write_replay(kept / f"{seed}.html", run.scenario, flown.topics, flown.violations)
    return RunOutcome(
        seed,
        through_nodes=False,
        what=run_description(run),
        violations=flown.violations,
        seconds=perf_counter() - began,
        air=air,
    )


def fly_pure(run: Run) -> JudgedFlight:
    """Return the run's flight by closed_loop; an error counts as a violation."""
    topics: dict[str, list[Signal]] = {topic: [] for topic in JUDGED}
    trace = None
    try:
        for tick, answer in answered_ticks(run.scenario, flight_options(run)):
            seen: tuple[Signal, ...] = (tick.truth, tick.truth_interference, tick.frame)
            heard = (*seen, answer.state, answer.reference_safe, answer.command)
            for signals, one in zip(topics.values(), heard, strict=True):
                signals.append(one)
        trace = trace_in_lockstep(topics)
        violations = judge(trace, circumstances_of(run))
    except Exception as error:  # noqa: BLE001 - a campaign looks for any error
        violations = (crash_violation(error),)
        trace = None
    return JudgedFlight(topics, violations, trace)


def flight_options(run: Run) -> FlightOptions:
    """Return the options of closed_loop for a run."""
    options = run.options
    return FlightOptions(
        mode=next(mode for mode in MODES if mode == options.mode),
        controller=options.controller,
        replan=options.replan,
        seed=run.seed,
        model=_model(run.scenario.model),
    )


@cache
def _model(name: str) -> InteractionModel:
    """Return an interaction model, read once: its file takes as long as 30 ticks."""
    return find_model(name).interaction


def circumstances_of(run: Run) -> Circumstances:
    """Return what a run's flight is judged by."""
    scenario = run.scenario
    return Circumstances(scenario.vehicle, faults=scenario.faults, aware=run.options.aware)


def crash_violation(error: Exception) -> Violation:
    """Return the violation of a run that raised an error."""
    return Violation(CRASH, f"{type(error).__name__}: {error}"[:200], float("nan"), float("nan"), 0.0)


def run_description(run: Run) -> str:
    """Return a one-line description of a run."""
    scenario, options = run.scenario, run.options
    faults = ", ".join(map(str, scenario.faults))
    flown = f"{run.document['description']}"[:40]
    by = f"{options.controller} {options.mode} {options.replan}"
    return f"{flown}; room {run.document['room']}; {by}; {faults}"


def keep_run(run: Run, signals: tuple[RecordedSignal, ...], folder: Path) -> None:
    """Write a run's scenario and the messages of its flight into a folder, replacing older ones."""
    write_scenario(run, folder / f"{run.seed}.yaml")
    write_text(yaml.safe_dump(asdict(run.options)), folder / f"{run.seed}.options.yaml")
    bag = folder / str(run.seed)
    shutil.rmtree(bag, ignore_errors=True)
    if signals:
        facts = scenario_facts(run.scenario, run.options, run.seed, f"{run.seed}.yaml")
        with BagWriter(bag, facts=facts) as writer:
            for one in signals:
                writer.write_signal(f"/{one.topic}", stamp_from_time(one.at), one.signal)


def write_scenario(run: Run, path: Path) -> None:
    """Write a run as a scenario file."""
    write_text(yaml.safe_dump(plain_document(run.document), sort_keys=False), path)


def plain_document(value: object) -> object:
    """Return a document without numpy numbers and tuples."""
    if isinstance(value, dict):
        return {str(key): plain_document(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain_document(one) for one in value]
    return value.item() if isinstance(value, np.generic) else value
