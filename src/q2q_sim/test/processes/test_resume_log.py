"""Finished work belongs to one run at a time."""

from collections.abc import Mapping
from pathlib import Path

import pytest
from made_outcomes import run_in_this_process

from q2q_sim.campaigns.falsification import search_record
from q2q_sim.campaigns.falsification.candidate_flight import CandidateFlight
from q2q_sim.campaigns.random_runs import parallel_runs
from q2q_sim.campaigns.random_runs.run_outcome import RunOutcome
from q2q_sim.commands import ablation, campaign, robustness
from q2q_sim.experiments.ablation import fill_ablation
from q2q_sim.experiments.ablation.ablation_numbers import Numbers, read_numbers
from q2q_sim.experiments.robustness import fill_robustness
from q2q_sim.experiments.robustness.perturbed_flight import Errors, PerturbedFlight
from q2q_sim.processes.resume_log import read_entries


def test_a_second_campaign_into_a_folder_is_refused_while_the_first_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    statuses: list[int] = []
    asked = ["--runs", "1", "--out", str(tmp_path)]

    def fly(seed: int, kept: Path, air: str) -> RunOutcome:  # noqa: ARG001
        statuses.append(campaign.main(asked))
        return RunOutcome(seed, through_nodes=False, what="made up", violations=(), seconds=0.0)

    run_in_this_process(monkeypatch)
    monkeypatch.setattr(parallel_runs, "fly_and_judge", fly)
    assert campaign.main(asked) == 0
    assert statuses == [2]
    assert "runs.jsonl is written by another run: wait for it" in capsys.readouterr().err
    assert campaign.main(asked) == 0
    assert len((tmp_path / "runs.jsonl").read_text().splitlines()) == 1


def test_a_second_guided_campaign_into_a_folder_is_refused_while_the_first_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    statuses: list[int] = []
    asked = ["--guided", "--runs", "1", "--bug-runs", "0", "--out", str(tmp_path)]

    def fly(_: object) -> CandidateFlight:
        statuses.append(campaign.main(asked))
        return CandidateFlight(())

    run_in_this_process(monkeypatch)
    monkeypatch.setattr(search_record, "fly_candidate", fly)
    assert campaign.main(asked) == 0
    assert statuses == [2]
    assert "searches.jsonl is written by another run: wait for it" in capsys.readouterr().err


def number_of(document: Mapping[str, object]) -> int:
    if not isinstance(document["n"], int):
        raise ValueError("no n")  # noqa: TRY004  a bad document
    return document["n"]


def test_a_last_line_without_its_end_is_removed_and_flown_again(tmp_path: Path) -> None:
    log = tmp_path / "log.jsonl"
    for cut in ('{"n": 2', '{"n": 2}'):
        log.write_text('{"n": 1}\n' + cut)
        assert read_entries(log, number_of) == [1]
        assert log.read_text() == '{"n": 1}\n'
    assert read_entries(tmp_path / "none.jsonl", number_of) == []


@pytest.mark.parametrize("line", ['{"n": "x"}', "{", "", "[" * 100_000])
def test_a_wrong_line_with_its_end_is_refused_wherever_it_is(tmp_path: Path, line: str) -> None:
    log = tmp_path / "log.jsonl"
    for text in (f'{{"n": 1}}\n{line}\n', f'{{"n": 1}}\n{line}\n{{"n": 3}}\n'):
        log.write_text(text)
        with pytest.raises(ValueError, match=r"log.jsonl, line 2: .*; remove the line, or the file"):
            read_entries(log, number_of)
        assert log.read_text() == text


def test_a_file_that_is_nested_too_deeply_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "numbers.json"
    file.write_text("[" * 100_000)
    with pytest.raises(ValueError, match=r"numbers\.json is not an ablation .*remove it, or give another"):
        read_numbers(file, 4)
    with pytest.raises(ValueError, match=r"numbers\.json has no results of flights .*remove it, or give"):
        fill_robustness.read(file)


def test_a_second_ablation_into_a_file_is_refused_until_the_first_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file is replaced after each flight, so that no lock on its content would hold."""
    statuses: list[int] = []
    file = tmp_path / "numbers.json"
    asked = ["--json", str(file), "--out", str(tmp_path / "page.md")]

    def fill(numbers: Numbers, *_: object) -> None:
        numbers.save(file)
        if not statuses:
            statuses.append(ablation.main(asked))

    monkeypatch.setattr(fill_ablation, "_fill", fill)
    ablation.main(asked)
    assert statuses == [1]
    assert f"{file} is written by another run: wait for it" in capsys.readouterr().err
    assert read_numbers(file, 4) == Numbers(4)


def test_a_second_robustness_into_a_file_is_refused_until_the_first_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    statuses: list[int] = []
    file = tmp_path / "numbers.json"
    asked = ["--airs", "ring", "--json", str(file), "--out", str(tmp_path / "page.md")]

    def fly(_: PerturbedFlight) -> Errors:
        if len(statuses) < 2:
            statuses.append(robustness.main(asked))
        return Errors(0.1, 0.2, 0.004)

    monkeypatch.setattr(fill_robustness, "fly_perturbed", fly)
    assert robustness.main(asked) == 0
    assert statuses == [1, 1]  # before and after the file was replaced
    assert f"{file} is written by another run: wait for it" in capsys.readouterr().err
