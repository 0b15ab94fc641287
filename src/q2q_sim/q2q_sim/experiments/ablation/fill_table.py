"""Missing flights of the ablation and its table."""

import json
import shlex
from argparse import Namespace
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from q2q_model.files.model_file import ModelFile, decode, encode
from q2q_model.identification.intervals import Interval
from q2q_model.signals.values import Array
from q2q_sim.experiments.ablation.ablation_cases import CASES, Case
from q2q_sim.experiments.ablation.ablation_table import key, page
from q2q_sim.experiments.ablation.contenders import CONTENDERS
from q2q_sim.experiments.ablation.learned_model import Learned, learn
from q2q_sim.experiments.ablation.trial import trial
from q2q_sim.scenarios.choices import TABLE_ONLY

READING = (
    "Medians over n replicas, each with its own noise, air, losses and rotors, with 95 % intervals; rooms "
    "without chance have one. 'Lower' is the lowest vehicle over the whole flight; 'under' counts vehicles "
    "under another and for 1 s after; 'clear air' the same flight's vehicles under nobody for 3 s. What is "
    "compared, and what each is given: `q2q_sim.experiments.ablation.contenders`; cases: "
    "`q2q_sim.experiments.ablation.ablation_cases`."
)
LEARNED = (
    "The controllers' models were learned from other flights in the same air, in the same run "
    "(`q2q_sim.experiments.ablation.learned_model`):"
)
CAUTION = (
    "**What was flown in what.** In the measured wake the air and the learned model are the same law, a "
    "smooth jet, so the fit is nearly perfect (R² 0.986); on the real flights that the air was fitted to,"
    " the law explains 0.865. In that air a ratio under / clear of 1.05 and worst errors 13 to 24 times "
    "smaller than ignoring's show how well a controller uses a model that is right. They are no claim "
    "about real air. Independent re-runs of the MPC with observer, in the same wake plus the residual "
    "that real flights leave, gave under / clear 3.5 and a worst error 3.8 times smaller in "
    "`table6_room`, and 4.6 and 4.8 in `stack3`. Real pairs, flown by their onboard controllers, have 2.5"
    " under / clear (4.65 cm and 1.87 cm rms; Neural-Swarm2's flights). In the paper wake the model is of"
    " another law than the air."
)
FIRST = ("ignoring", "MPC observer")
"""Flown first, so that an interrupted run has the worst and the best of every case."""
WAKES = ("measured", "paper")
"""Wakes with a learned model."""


@dataclass(slots=True)
class Results:
    """Finished flights, saved to a file after each."""

    file: Path
    seeds: int
    models: dict[str, Learned]
    cells: dict[str, Array]

    def save(self) -> None:
        """Replace the file, so that an interrupted run loses at most one flight."""
        body = {
            "seeds": self.seeds,
            "models": {wake: _plain(learned) for wake, learned in self.models.items()},
            "cells": {name: values.tolist() for name, values in self.cells.items()},
        }
        self.file.parent.mkdir(parents=True, exist_ok=True)
        fresh = self.file.with_suffix(".part")
        fresh.write_text(json.dumps(body, indent=1) + "\n", encoding="utf-8")
        fresh.replace(self.file)


def run(given: Namespace) -> int:
    """Fly what is missing, write the table; return the exit status."""
    results = read(given.json, given.seeds)
    unknown = sorted(set(given.only or ()) - {case.scenario for case in CASES})
    if unknown:
        known = ", ".join(sorted({case.scenario for case in CASES}))
        raise ValueError(f"--only {' '.join(unknown)}: choose some of {known}")
    wanted = [case for case in CASES if not given.only or case.scenario in given.only]
    if not given.table_only:
        _fill(results, wanted, given.jobs)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    command = f"ros2 run q2q_sim ablation {shlex.join(word for word in given.words if word != TABLE_ONLY)}"
    given.out.write_text(page(results.cells, notes(results), command), encoding="utf-8")
    print(f"table: {given.out}\nnumbers: {given.json}")
    return 0


def read(file: Path, seeds: int) -> Results:
    """Return the results in a file, empty if there is none; raise ValueError for other seeds."""
    if not file.is_file():
        return Results(file, seeds, {}, {})
    try:
        body = json.loads(file.read_text(encoding="utf-8"))
        models = {wake: _learned(plain) for wake, plain in body["models"].items()}
        cells = {name: np.array(values, dtype=np.float64) for name, values in body["cells"].items()}
        flown = int(body["seeds"])
    except (KeyError, TypeError, AttributeError, ValueError) as wrong:
        raise ValueError(f"{file} is not an ablation ({wrong}): remove it, or give another --json") from wrong
    if flown != seeds:
        raise ValueError(f"{file} holds {flown} seeds, not {seeds}: give another --json, or --seeds {flown}")
    return Results(file, seeds, models, cells)


def notes(results: Results) -> list[str]:
    """Return the notes below the table."""
    models = [
        f"- {wake} wake: {learned.model!r}, loading {learned.loading:.2f}{_shown(learned.loading_interval)}"
        + (f"; R² {learned.r2:.3f} on a flight left out" if learned.r2 is not None else "")
        for wake, learned in sorted(results.models.items())
    ]
    missing = len(CASES) * len(CONTENDERS) - len(results.cells)
    rest = [f"{missing} of the flights are missing: run the same command again."] if missing > 0 else []
    return [*rest, READING, CAUTION, LEARNED, "\n".join(models)]


def _fill(results: Results, wanted: Sequence[Case], jobs: int) -> None:
    """Learn missing models and fly missing flights."""
    if not 1 <= results.seeds <= 25 or jobs < 1:
        raise ValueError(f"seeds = {results.seeds}, jobs = {jobs}: 1 to 25 seeds, 1 job or more")
    first = [(case, contender) for contender in FIRST for case in wanted]
    pairs = dict.fromkeys(first + [(case, contender) for case in wanted for contender in CONTENDERS])
    missing = [pair for pair in pairs if key(*pair) not in results.cells]
    pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"))
    bar = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with pool, Progress(*bar, console=Console(stderr=True)) as progress:
        unknown = [wake for wake in WAKES if missing and wake not in results.models]
        for wake, work in [(wake, pool.submit(learn, wake)) for wake in unknown]:
            results.models[wake] = work.result()
            results.save()
        task = progress.add_task("flights", total=len(missing))
        flights = {
            pool.submit(trial, *pair, _model_for(pair[0], results.models), results.seeds): pair
            for pair in missing
        }
        try:
            for done in as_completed(flights):
                results.cells[key(*flights[done])] = done.result()
                results.save()
                progress.advance(task)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _model_for(case: Case, models: Mapping[str, Learned]) -> Learned:
    return models["paper" if case.wake == "paper" else "measured"]


def _shown(found: Interval | None) -> str:
    return "" if found is None else f" (95 % interval {found.low:.2f} to {found.high:.2f})"


def _plain(learned: Learned) -> dict[str, object]:
    found = learned.loading_interval
    return {
        "file": encode(ModelFile(learned.model)),
        "loading": learned.loading,
        "loading_interval": None if found is None else found.as_list(),
        "r2": learned.r2,
    }


def _learned(plain: Mapping[str, object]) -> Learned:
    r2, found = plain["r2"], plain.get("loading_interval")  # runs of before its time have none
    model = decode(str(plain["file"])).interaction
    interval = Interval(*(float(str(end)) for end in found)) if isinstance(found, list) else None
    return Learned(model, float(str(plain["loading"])), None if r2 is None else float(str(r2)), interval)
