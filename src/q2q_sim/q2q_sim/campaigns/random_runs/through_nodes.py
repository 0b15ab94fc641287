"""Runs of a campaign through the real nodes in lockstep, checked by the policies and against closed_loop.

The nodes must reproduce closed_loop to AGREEMENT_M under any fault; a deviation is a violation.
"""

import os
import shutil
import warnings
from pathlib import Path
from time import perf_counter
from typing import Self

import numpy as np

from q2q_model.bag import BagError
from q2q_sim.campaigns.random_runs.campaign_flight import (
    JUDGED,
    circumstances_of,
    crash_violation,
    fly_pure,
    keep_run,
    run_description,
    write_scenario,
)
from q2q_sim.campaigns.random_runs.random_run import Run, draw_run
from q2q_sim.campaigns.random_runs.run_outcome import MODE_AGREEMENT, RunOutcome
from q2q_sim.flight_bag.recorded_trace import trace_in
from q2q_sim.monitors.policies import FlightTrace, Violation, judge, trace_in_lockstep
from q2q_sim.node_flights.flight_nodes import node_specs
from q2q_sim.node_flights.flight_request import FlightRequest, load_scenario
from q2q_sim.node_flights.flight_worker import FlightWorker
from q2q_sim.node_flights.scenario_flight import fly_through_nodes
from q2q_sim.node_flights.unfinished_bag import why_unfinished

AGREEMENT_M = 1e-9
"""Largest deviation of a flight through the nodes from closed_loop [m]: rounding of reordered sums."""
APART_EVERY = 20
"""Period of runs with a process for each node; the others use one worker process."""


class NodeFlights:
    """Folder of flights; a context manager that deletes temporary files."""

    def __init__(self, folder: Path, kept: Path, air: str = "") -> None:
        """Take the folder of running flights, that of violations, and an air in place of the scenarios'."""
        self._air = air
        self._folder = folder / str(os.getpid())
        self._kept = kept
        folder.mkdir(parents=True, exist_ok=True)
        self._worker = FlightWorker(folder / "nodes.log")

    def __enter__(self) -> Self:
        """Start the process of the nodes and return the flights."""
        self._worker.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        """End the process and delete the folder of running flights."""
        self._worker.__exit__()
        shutil.rmtree(self._folder, ignore_errors=True)

    def fly_and_judge(self, seed: int) -> RunOutcome:
        """Fly the run of a seed through the nodes and check it; a violation leaves bag and scenario."""
        began = perf_counter()
        run = draw_run(seed, self._air)
        violations = self._flown(run)
        if violations:
            self._keep(run)
        shutil.rmtree(self._folder, ignore_errors=True)
        took = perf_counter() - began
        what = run_description(run)
        return RunOutcome(
            seed, through_nodes=True, what=what, violations=violations, seconds=took, air=self._air
        )

    def _flown(self, run: Run) -> tuple[Violation, ...]:
        path, options = self._folder / "run.yaml", run.options
        write_scenario(run, path)
        request = FlightRequest(
            scenario=str(path),
            mode=options.mode,
            controller=options.controller,
            replan=options.replan,
            seed=run.seed,
            record=JUDGED,
            stack=run.seed % APART_EVERY > 0,
        )
        bag = self._folder / "bag"
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # injected clock jumps are corrected with a warning
                self._through(request, bag)
            trace = trace_in(bag)
        except Exception as error:  # noqa: BLE001 - a campaign looks for any error
            return (crash_violation(error),)
        found = judge(trace, circumstances_of(run))
        return (*found, *mode_disagreement(trace, trace_in_lockstep(fly_pure(run).topics)))

    def _through(self, request: FlightRequest, bag: Path) -> None:
        folder = self._folder / "nodes"
        if not request.stack:
            fly_through_nodes(request, folder, bag, lambda _: None)
        else:
            self._worker.fly(node_specs(load_scenario(request), request, folder, bag), folder)
        if unfinished := why_unfinished(bag, folder):
            raise BagError(f"the bag was not finished: {unfinished}")

    def _keep(self, run: Run) -> None:
        keep_run(run, (), self._kept)
        place = self._kept / f"{run.seed}_nodes"
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(self._folder, place)


def mode_disagreement(through_nodes: FlightTrace, pure: FlightTrace) -> tuple[Violation, ...]:
    """Return the violation if a flight through the nodes deviates from closed_loop."""
    if through_nodes.true_pos.shape != pure.true_pos.shape:
        ticks = float(len(through_nodes.t) - len(pure.t))
        return (Violation(MODE_AGREEMENT, "number of ticks", float("nan"), ticks, 0.0),)
    apart = np.abs(through_nodes.true_pos - pure.true_pos).max(axis=(1, 2), initial=0.0)  # (T,)
    bad = ~(apart <= AGREEMENT_M)
    if not bad.any():
        return ()
    first = int(np.flatnonzero(bad)[0])
    return (Violation(MODE_AGREEMENT, "truth", float(pure.t[first]), float(apart.max()), AGREEMENT_M),)
