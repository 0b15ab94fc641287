"""A short campaign: runs are their seeds, go on where they were broken off, and keep what they violate."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from q2q_model.bag import BagReader
from q2q_sim.bag_topics.recorded_trace import trace_in
from q2q_sim.commands import campaign
from q2q_sim.experiments.campaign import campaign_flight, parallel_runs, random_run
from q2q_sim.experiments.campaign.campaign_flight import JUDGED
from q2q_sim.experiments.campaign.parallel_runs import run_outcomes
from q2q_sim.experiments.campaign.random_run import CALM_S, EXCERPTS, draw_run, excerpt_document
from q2q_sim.experiments.campaign.run_outcome import (
    CRASH,
    DIED,
    MODE_AGREEMENT,
    RunOutcome,
    as_document,
    from_document,
    summary,
)
from q2q_sim.experiments.campaign.through_nodes import NodeFlights, mode_disagreement
from q2q_sim.experiments.falsification import bug_score, guided_campaign, search_record
from q2q_sim.experiments.falsification.candidate_flight import CandidateFlight
from q2q_sim.experiments.falsification.counterexample import read_case
from q2q_sim.experiments.falsification.seeded_bugs import SEEDED_BUGS
from q2q_sim.monitors.policies import POLICIES, FlightTrace, Violation, trace_in_lockstep
from q2q_sim.node_flights.flight_nodes import node_specs
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.node_flights.resident import ResidentNodes
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario_document import scenario_from_document

KEYS = {"runs", "through_nodes", "violations", "by_policy", "seeds_of_violations", "seconds"}
ONCE_BROKEN = (
    15,
    226,
    237,
    261,
    298,
    354,
    363,
    382,
    450,
    542,
    552,
    565,
    721,
    736,
    790,
    836,
    850,
    1174,
    1514,
    1517,
    1978,
)
"""Seeds that a policy was violated in, each by a cause of its own: docs/findings.md has them."""
BROKEN = Violation("tilt", "cf1", 1.0, 0.5, 0.36)


def test_a_short_campaign_violates_nothing(tmp_path: Path) -> None:
    asked = [
        "--runs",
        "3",
        "--through-nodes",
        "1",
        "--out",
        str(tmp_path),
        "--json",
        str(tmp_path / "it.json"),
    ]
    assert campaign.main(asked) == 0
    found = json.loads((tmp_path / "it.json").read_text())
    assert set(found) == KEYS
    assert (found["runs"], found["through_nodes"], found["violations"]) == (3, 1, 0)
    assert found["by_policy"] == dict.fromkeys((*POLICIES, CRASH, MODE_AGREEMENT), 0)
    assert found["seeds_of_violations"] == []
    assert found["seconds"] > 0.0
    assert not (tmp_path / "violations").exists()


@pytest.mark.parametrize("seed", ONCE_BROKEN)
def test_what_once_violated_a_policy_violates_none(seed: int) -> None:
    assert campaign_flight.fly_pure(draw_run(seed)).violations == ()


@pytest.mark.parametrize("seed", [20, 44])
def test_what_once_violated_a_policy_through_the_nodes_violates_none(seed: int, tmp_path: Path) -> None:
    with NodeFlights(tmp_path / "nodes", tmp_path / "kept") as flights:
        assert flights.fly_and_judge(seed).violations == ()


def test_a_run_in_an_air_is_flown_by_the_vehicles_of_that_air() -> None:
    seed = next(seed for seed in range(100) if draw_run(seed).document["vehicle"] == "textbook_065")
    own, run = draw_run(seed), draw_run(seed, "bent")
    assert (run.scenario.vehicle.name, run.scenario.air) == ("crazyflie_2_0", "bent")
    assert run.document["vehicles"] == own.document["vehicles"]
    assert run.document["overrides"] != own.document["overrides"]  # the bound on thrust is the vehicle's


def test_a_run_is_its_seed_and_seeds_draw_everything() -> None:
    assert draw_run(7) == draw_run(7)
    runs = [draw_run(seed) for seed in range(60)]
    assert len({str(run.document["description"]) for run in runs}) == len(EXCERPTS)
    assert {run.options.controller for run in runs} == {"pid", "mpc"}
    assert {str(run.document["room"]) for run in runs} == set(random_run.ROOMS)
    for run in runs:
        scenario = run.scenario
        assert 1 <= len(scenario.faults) <= random_run.MOST
        assert all(fault.start <= scenario.duration - CALM_S for fault in scenario.faults)


@pytest.mark.parametrize("excerpt", EXCERPTS, ids=lambda excerpt: excerpt.scenario)
def test_an_excerpt_begins_and_ends_where_its_scenario_is_then(excerpt: random_run.Excerpt) -> None:
    whole = library.load(excerpt.scenario)
    document = excerpt_document(library.document(excerpt.scenario), excerpt)
    short = scenario_from_document("excerpt", document)
    assert short.duration == pytest.approx((excerpt.end - excerpt.begin) * excerpt.pace)
    for long_way, way in zip(whole.waypoints, short.waypoints, strict=True):
        at_rest = [point.pos for point in long_way.waypoints if point.t <= excerpt.begin][-1]
        assert way.waypoints[0].pos == at_rest
        assert way.waypoints[0].t == 0.0
        assert all(a.t < b.t for a, b in zip(way.waypoints, way.waypoints[1:], strict=False))


def ended(seed: int, *violations: Violation) -> RunOutcome:
    return RunOutcome(seed, through_nodes=False, what="made up", violations=violations, seconds=2.0)


def test_a_campaign_counts_runs_not_violations() -> None:
    found = summary([ended(1), ended(2, BROKEN, replace(BROKEN, who="cf2")), ended(3)], 6.0)
    assert found["violations"] == 1
    assert found["by_policy"]["tilt"] == 1
    assert found["seeds_of_violations"] == [2]


def test_outcomes_survive_a_file_and_nonsense_is_refused() -> None:
    one = ended(2, BROKEN)
    assert from_document(json.loads(json.dumps(as_document(one)))) == one
    with pytest.raises(ValueError, match="not an outcome of a run"):
        from_document({"seed": 1})
    with pytest.raises(ValueError, match="unknown policy 'tlit'; known are separation, zone, "):
        from_document(as_document(ended(2, replace(BROKEN, policy="tlit"))))


def test_an_interrupted_campaign_goes_on_and_a_violation_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    flown: list[int] = []

    def fly(seed: int, kept: Path, air: str) -> RunOutcome:  # noqa: ARG001
        flown.append(seed)
        return ended(seed, *([BROKEN] if seed == 12 else []))

    monkeypatch.setattr(
        parallel_runs, "_local", lambda work, numbers, *_: map(work, numbers)
    )  # in this process
    monkeypatch.setattr(parallel_runs, "fly_and_judge", fly)
    asked = ["--seed", "10", "--out", str(tmp_path)]
    assert campaign.main(["--runs", "2", *asked]) == 0
    with (tmp_path / "runs.jsonl").open("a") as log:
        for seed, what in ((12, "died"), (13, DIED)):  # 12 as earlier versions kept what another run killed
            log.write(json.dumps(as_document(replace(ended(seed, BROKEN), what=what))) + "\n")
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
    monkeypatch.setattr("q2q_sim.experiments.campaign.parallel_runs.RECYCLE", 1)
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
    with ResidentNodes(tmp_path / "nodes.log") as nodes:

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
        with pytest.raises(ValueError, match="parameter seed: allowed is 0 or more"):
            flown("third", -1)
        again = flown("fourth", run.seed)
    pure = trace_in_lockstep(campaign_flight.fly_pure(short).topics)
    assert mode_disagreement(first, pure) == mode_disagreement(again, pure) == ()
    assert [one.policy for one in mode_disagreement(second, pure)] == [MODE_AGREEMENT]


def test_a_guided_campaign_keeps_its_case_resumes_and_counts_seeded_bugs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    flown: list[int] = []

    def fly(run: random_run.Run) -> CandidateFlight:
        flown.append(run.seed)
        return CandidateFlight((BROKEN,) if run.seed == 37 else (), {"setpoint_error": -float(len(flown))})

    monkeypatch.setattr(
        parallel_runs, "_local", lambda work, numbers, *_: map(work, numbers)
    )  # in this process
    monkeypatch.setattr(search_record, "fly_candidate", fly)
    monkeypatch.setattr(bug_score, "fly_candidate", lambda _: CandidateFlight(()))
    asked = ["--guided", "--runs", "110", "--bug-runs", "3", "--out", str(tmp_path)]
    asked += ["--json", str(tmp_path / "it.json")]
    assert campaign.main(asked) == 1
    found = json.loads((tmp_path / "it.json").read_text())
    assert {name: found[name] for name in ("runs", "violations", "bug_runs")} == {
        "runs": 50 + 8 + 10,  # seed 37 is the eighth run of the random phase of the second search
        "violations": 1,
        "bug_runs": 3,
    }
    assert (found["seeded_bugs"], found["seeded_found"], found["blind_found"]) == (20, 0, 0)
    assert found["by_policy"] == {"tilt": 1}
    (case,) = found["cases"]
    assert read_case(Path(case)).run.scenario.faults == ()  # this one needs none
    count = len(flown)
    assert campaign.main(asked) == 1
    assert len(flown) == count
    assert json.loads((tmp_path / "it.json").read_text()) == found
    log = tmp_path / "searches.jsonl"
    whole = log.read_text().splitlines()
    log.write_text(log.read_text()[:-20])  # killed while it wrote the last search
    assert campaign.main(asked) == 1
    assert [json.loads(line)["seed"] for line in log.read_text().splitlines()] == [
        json.loads(line)["seed"] for line in whole
    ]
    monkeypatch.setattr(guided_campaign, "fly_candidate", fly)
    assert campaign.main(["--case", case, "--out", str(tmp_path)]) == 1
    page = tmp_path / f"{Path(case).stem}.html"
    said = capsys.readouterr().out
    assert "tilt: cf1 at 1.00 s: 0.5 rad of commanded tilt, at most 0.36 rad is allowed" in said
    assert f"replay: {page}" in said
    assert "cf1, tilt" in page.read_text()
    assert "cf1, tilt" in Path(case).with_suffix(".html").read_text()


def test_a_bug_counts_as_found_only_by_a_run_that_the_sound_stack_keeps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bug = SEEDED_BUGS[0]
    sound = vars(bug.place)[bug.function]

    def fly(run: random_run.Run) -> CandidateFlight:
        seeded = vars(bug.place)[bug.function] is not sound
        both = CandidateFlight((BROKEN,))  # also without the bug
        return CandidateFlight((replace(BROKEN, policy="state_age"),)) if seeded and run.seed == 4 else both

    monkeypatch.setattr(bug_score, "fly_candidate", fly)
    one = bug_score.score_bugs(0, 10, 0)
    assert (one.bug, one.guided, one.blind) == (bug.name, 5, 5)
    assert bug_score.score_bugs(0, 4, 0).blind == 0
