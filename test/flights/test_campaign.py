"""A short campaign: it goes on where it was broken off, and keeps what runs violate."""

import json
from dataclasses import asdict, replace
from pathlib import Path

import pytest
from made_outcomes import BROKEN, ended, run_in_this_process

from q2q_model.bag import BagReader
from q2q_sim.campaigns.random_runs import campaign_flight, parallel_runs
from q2q_sim.campaigns.random_runs.campaign_flight import JUDGED
from q2q_sim.campaigns.random_runs.parallel_runs import run_outcomes
from q2q_sim.campaigns.random_runs.random_run import draw_run
from q2q_sim.campaigns.random_runs.run_outcome import (
    CRASH,
    DIED,
    MODE_AGREEMENT,
    RunOutcome,
    from_document,
    summary,
)
from q2q_sim.campaigns.random_runs.through_nodes import mode_disagreement
from q2q_sim.commands import campaign
from q2q_sim.flight_bag.recorded_trace import trace_in
from q2q_sim.monitors.policies import POLICIES, FlightTrace, trace_in_lockstep
from q2q_sim.node_flights.flight_nodes import node_specs
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.flight_worker import FlightWorker
from q2q_sim.scenarios import library

KEYS = {"runs", "through_nodes", "violations", "by_policy", "seeds_of_violations", "seconds"}


def test_a_short_campaign_violates_nothing(tmp_path: Path) -> None:
    file = tmp_path / "it.json"
    asked = ["--runs", "3", "--through-nodes", "1", "--out", str(tmp_path), "--json", str(file)]
    assert campaign.main(asked) == 0
    found = json.loads(file.read_text())
    assert set(found) == KEYS
    assert (found["runs"], found["through_nodes"], found["violations"]) == (3, 1, 0)
    assert found["by_policy"] == dict.fromkeys((*POLICIES, CRASH, MODE_AGREEMENT), 0)
    assert found["seeds_of_violations"] == []
    assert found["seconds"] > 0.0
    assert not (tmp_path / "violations").exists()


def test_a_campaign_counts_runs_not_violations() -> None:
    found = summary([ended(1), ended(2, BROKEN, replace(BROKEN, who="cf2")), ended(3)], 6.0)
    assert found["violations"] == 1
    assert found["by_policy"]["tilt"] == 1
    assert found["seeds_of_violations"] == [2]


def test_outcomes_survive_a_file_and_nonsense_is_refused() -> None:
    one = ended(2, BROKEN)
    assert from_document(json.loads(json.dumps(asdict(one)))) == one
    with pytest.raises(ValueError, match="not an outcome of a run"):
        from_document({"seed": 1})
    with pytest.raises(ValueError, match="unknown policy 'tlit'; choose one of separation, zone, "):
        from_document(asdict(ended(2, replace(BROKEN, policy="tlit"))))


def test_an_interrupted_campaign_goes_on_and_a_violation_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    flown: list[int] = []

    def fly(seed: int, kept: Path, air: str) -> RunOutcome:  # noqa: ARG001
        flown.append(seed)
        return ended(seed, *([BROKEN] if seed == 12 else []))

    run_in_this_process(monkeypatch)
    monkeypatch.setattr(parallel_runs, "fly_and_judge", fly)
    asked = ["--seed", "10", "--out", str(tmp_path)]
    assert campaign.main(["--runs", "2", *asked]) == 0
    with (tmp_path / "runs.jsonl").open("a") as log:
        log.write(json.dumps(asdict(replace(ended(13, BROKEN), what=DIED))) + "\n")
        log.write('{"seed": 14, "thr')  # killed while writing
    assert campaign.main(["--runs", "5", *asked]) == 1
    assert flown == [10, 11, 12, 14]
    assert campaign.main(["--runs", "5", "--air", "bent", *asked]) == 2
    assert flown == [10, 11, 12, 14]
    lines = capsys.readouterr()
    assert "seeds of violations: [12, 13]" in lines.out
    assert "tilt: cf1 at 1.00 s: 0.5" in lines.err
    assert "runs.jsonl holds runs in the air of each scenario: give another --out" in lines.err


def test_an_air_that_cannot_be_flown_in_ends_a_campaign_before_its_first_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = tmp_path / "cut.air"
    broken.write_text('{"jet": ')
    out = tmp_path / "campaign"
    assert campaign.main(["--runs", "1", "--air", str(broken), "--out", str(out)]) == 2
    assert campaign.main(["--runs", "1", "--air", "lacking", "--out", str(out)]) == 2
    lines = capsys.readouterr()
    assert "cut.air" in lines.err
    assert "no air 'lacking'" in lines.err
    assert not out.exists()


def test_processes_that_are_replaced_fly_every_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("q2q_sim.processes.parallel_work.RECYCLE", 1)
    flown = list(run_outcomes("local", range(200, 203), 2, tmp_path))
    assert sorted(one.seed for one in flown) == [200, 201, 202]
    assert all(one.what and one.seconds > 0.0 for one in flown)


def test_a_run_that_raises_is_a_crash_and_leaves_its_bag(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("made up")

    monkeypatch.setattr(campaign_flight, "judge", broken)
    found = campaign_flight.fly_and_judge(5, tmp_path)
    assert [one.policy for one in found.violations] == [CRASH]
    assert "ZeroDivisionError: made up" in found.violations[0].who
    assert library.load(str(tmp_path / "5.yaml")).faults == draw_run(5).scenario.faults
    whole = list(BagReader(tmp_path / "5").signals())
    (tmp_path / "5" / "metadata.yaml").unlink()  # killed while it wrote, and flown again
    campaign_flight.fly_and_judge(5, tmp_path)
    assert (tmp_path / "5" / "metadata.yaml").exists()
    assert len(list(BagReader(tmp_path / "5").signals())) == len(whole)


def test_flight_after_flight_through_the_nodes_of_one_process_is_that_of_closed_loop(tmp_path: Path) -> None:
    run = draw_run(1)
    short = replace(run, document={**run.document, "duration": 0.5})
    scenario = tmp_path / "run.yaml"
    campaign_flight.write_scenario(short, scenario)
    with FlightWorker(tmp_path / "nodes.log") as nodes:

        def flown(name: str, seed: int) -> FlightTrace:
            request = FlightRequest(
                str(scenario), run.options.mode, run.options.controller, seed=seed, stack=True, record=JUDGED
            )
            folder = tmp_path / name
            folder.mkdir()
            specs = node_specs(short.scenario, request, folder, folder / "bag")
            assert nodes.fly(specs, folder).ticks == 50
            return trace_in(folder / "bag")

        first, second = flown("first", run.seed), flown("second", run.seed + 1)
        with pytest.raises(ValueError, match="parameter seed must be at least 0"):
            flown("third", -1)
        again = flown("fourth", run.seed)
    pure = trace_in_lockstep(campaign_flight.fly_pure(short).topics)
    assert mode_disagreement(first, pure) == mode_disagreement(again, pure) == ()
    assert [one.policy for one in mode_disagreement(second, pure)] == [MODE_AGREEMENT]
