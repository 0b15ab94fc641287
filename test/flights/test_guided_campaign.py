"""A guided campaign keeps its case, resumes, and counts the seeded bugs that it finds."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from made_outcomes import BROKEN, run_in_this_process

from q2q_sim.campaigns.falsification import bug_score, guided_campaign, search_record
from q2q_sim.campaigns.falsification.candidate_flight import CandidateFlight
from q2q_sim.campaigns.falsification.counterexample import read_case
from q2q_sim.campaigns.falsification.seeded_bugs import SEEDED_BUGS
from q2q_sim.campaigns.random_runs import random_run
from q2q_sim.commands import campaign


def test_a_guided_campaign_keeps_its_case_resumes_and_counts_seeded_bugs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    flown: list[int] = []

    def fly(run: random_run.Run) -> CandidateFlight:
        flown.append(run.seed)
        return CandidateFlight((BROKEN,) if run.seed == 37 else (), {"setpoint_error": -float(len(flown))})

    run_in_this_process(monkeypatch)
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
    assert "tilt: cf1 at 1.00 s: 0.5 rad of commanded tilt (maximum 0.36 rad)" in said
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
