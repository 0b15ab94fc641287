"""Options that would change nothing are refused."""

import pytest

from q2q_sim.commands import campaign, explain


@pytest.mark.parametrize(
    ("option", "value"), [("of", "height"), ("orders", "6"), ("draws", "1"), ("out", "why")]
)
def test_a_score_refuses_what_is_of_a_bag(
    option: str, value: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        explain.main(["--score", "1", f"--{option}", value])
    assert f"--{option} has no effect with --score" in capsys.readouterr().err


def test_a_bag_refuses_the_seed_of_a_score(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        explain.main(["bag", "--seed", "3"])
    assert "--seed has no effect with a bag" in capsys.readouterr().err


@pytest.mark.parametrize("given", [["--bug-runs", "80"], ["--bug-runs=3"]])
def test_runs_for_seeded_bugs_need_a_guided_campaign(
    given: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        campaign.main(["--runs", "2", *given])
    assert "--bug-runs needs --guided" in capsys.readouterr().err
