"""A campaign prints violations as they are, with whatever an error of a user's code says."""

import math
from collections.abc import Iterator
from pathlib import Path

import pytest

from q2q_sim.campaigns.random_runs import resumable_campaign
from q2q_sim.campaigns.random_runs.run_outcome import CRASH, RunOutcome
from q2q_sim.commands import campaign
from q2q_sim.monitors.policies import Violation


@pytest.mark.parametrize("said", ["bad value in [/tmp/file]", "acc [nan nan nan] of cf1: finite"])
def test_an_error_is_printed_whole(
    said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = Violation(CRASH, f"ValueError: {said}", math.nan, math.nan, 0.0)

    def outcomes(*_: object) -> Iterator[RunOutcome]:
        yield RunOutcome(0, through_nodes=False, what="made", violations=(broken,), seconds=1.0)

    monkeypatch.setattr(resumable_campaign, "run_outcomes", outcomes)
    assert campaign.main(["--runs", "1", "--out", str(tmp_path), "--json", str(tmp_path / "it.json")]) == 1
    printed = capsys.readouterr()
    assert said in " ".join(printed.err.split())
    assert "seeds of violations: [0]" in printed.out
    assert (tmp_path / "it.json").is_file()
