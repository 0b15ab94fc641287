"""The local searches of a guided search learn, and work that another search has kept is not resumed."""

import json
from collections.abc import Sequence
from pathlib import Path

import cma
import numpy as np
import pytest
from made_outcomes import run_in_this_process

from q2q_model.signals.values import Array
from q2q_sim.campaigns.falsification import search_record
from q2q_sim.campaigns.falsification.candidate_flight import CandidateFlight
from q2q_sim.campaigns.falsification.guided_search import LENGTH, guided_runs
from q2q_sim.campaigns.random_runs.random_run import Run
from q2q_sim.commands import campaign


def test_each_local_search_learns_from_the_margins_of_its_runs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    learned: list[float] = []
    tell = cma.CMAEvolutionStrategy.tell
    rng = np.random.default_rng(0)

    def record(self: object, vectors: Sequence[Array], margins: Sequence[float]) -> object:
        learned.extend(margins)
        return tell(self, vectors, margins)

    def judge(_: Run) -> CandidateFlight:
        return CandidateFlight((), {"setpoint_error": float(rng.random()), "floor": float(rng.random())})

    monkeypatch.setattr(cma.CMAEvolutionStrategy, "tell", record)
    runs = list(guided_runs(1, LENGTH, judge))
    first, second = runs[30:35], runs[40:45]
    assert len(runs) == 50
    assert learned in (
        [one.flight.margins[name] for some, name in zip((first, second), names, strict=True) for one in some]
        for names in (("setpoint_error", "floor"), ("floor", "setpoint_error"))
    )


def test_work_of_another_search_is_not_resumed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flown: list[Run] = []

    def fly(run: Run) -> CandidateFlight:
        flown.append(run)
        return CandidateFlight(())

    run_in_this_process(monkeypatch)
    monkeypatch.setattr(search_record, "fly_candidate", fly)
    asked = ["--guided", "--runs", "1", "--bug-runs", "0", "--out", str(tmp_path)]
    log = tmp_path / "searches.jsonl"
    assert campaign.main(asked) == campaign.main(asked) == 0
    assert len(flown) == 1
    kept = json.loads(log.read_text())
    del kept["search"]  # as older ones are
    log.write_text(json.dumps(kept) + "\n")
    assert campaign.main(asked) == 0
    assert len(flown) == 2
