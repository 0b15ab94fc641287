"""`plan` says in one line what cannot be planned, or contradicts itself."""

from pathlib import Path

import pytest
from section_4_1 import WRITTEN

from q2q_planner.commands.plan import main


def test_a_warm_start_of_other_vehicles_is_refused(
    crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other, out = tmp_path / "other.json", tmp_path / "plan.json"
    assert main([str(crossing), "--no-avoid", "--out", str(other)]) == 0
    crossing.write_text(WRITTEN.replace("cf2", "cf3"))
    assert main([str(crossing), "--warm-start", str(other), "--out", str(out)]) == 1
    assert "warm start of cf1, cf2: expected cf1, cf3" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("text", "arguments", "message"),
    [
        (WRITTEN.replace("t: 20", "t: 0.5"), [], "cf1, after waypoint 0"),
        (
            WRITTEN.replace("t: 20", "t: 30"),
            [],
            "cf1, waypoint 1 and cf2, waypoint 1 lie 0.1 m inside",
        ),
        (WRITTEN, ["--eps", "-1"], "--eps = -1.0; must be above 0 and below 5.0 m"),
        (WRITTEN, ["--model", "paper_law", "--threshold", "99"], "threshold = 99"),
        (WRITTEN, ["--model", "measured_law", "--eps", "0.3"], "--eps and --model both choose the zone"),
        (
            WRITTEN,
            ["--model", "measured_law", "--threshold", "1", "--shape", "ellipsoid"],
            "--shape and --model both choose the zone",
        ),
        (WRITTEN, ["--model", "none"], "--model none has no downwash, so no zone: name another, or give"),
        (
            WRITTEN,
            ["--no-avoid", "--model", "paper_law", "--cut", "0.9"],
            "--cut 0.9 needs --model, without --threshold (which it chooses) and --no-avoid",
        ),
        (WRITTEN, ["--threshold", "1"], "needs --model"),
    ],
)
def test_what_cannot_be_planned_is_said_in_one_line(
    text: str, arguments: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "bad.yaml", tmp_path / "plan.json"
    path.write_text(text)
    assert main([str(path), "--out", str(out), *arguments]) == 1
    error = capsys.readouterr().err
    assert message in error
    assert error.startswith("plan: ")
    assert "Traceback" not in error
    assert not out.exists()


def refusal(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Return the message of a command line that contradicts itself, which ends with status 2."""
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    return capsys.readouterr().err


def test_a_warm_start_without_a_search_is_refused(
    crossing: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "plan.json"
    words = refusal([str(crossing), "--no-avoid", "--warm-start", str(crossing), "--out", str(out)], capsys)
    assert "--warm-start starts the avoidance that --no-avoid omits: give one of them" in words
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--out", "crossing.yaml"], "the waypoint file and --out are both "),
        (["--out", "plan.json", "--json", "plan.json"], "--out and --json are both "),
        (["--out", "plan.json", "--csv", "new/../crossing.yaml"], "the waypoint file and --csv are both "),
        (["--out", "old.json", "--warm-start", "old.json"], "--warm-start and --out are both "),
        (["--out", "plan.json", "--upload", "old.json"], "old.json is a file; give a folder"),
        (["--out", "plan.json", "--figures", "old.json"], "old.json is a file; give a folder"),
        (["--out", "plan.json", "--csv", "old.json/a.csv"], "old.json is a file; it cannot hold a.csv"),
        (["--out", "plan.json", "--csv", "ups", "--upload", "ups"], "ups, which --upload needs as a folder"),
        (["--out", "plan.json", "--csv", "a", "--figures", "a/b"], "a, which --figures needs as a folder"),
        (["--out", "plan.json", "--csv", "plan.json/a.csv"], "plan.json, which --csv needs as a folder"),
    ],
)
def test_no_file_is_written_twice_or_over_another(
    options: list[str],
    words: str,
    crossing: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(crossing.parent)
    Path("old.json").write_text("{}")
    Path("new").mkdir()
    assert words in refusal(["crossing.yaml", *options], capsys)
    assert crossing.read_text() == WRITTEN
    assert not Path("plan.json").exists()


def test_an_absent_file_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path / "none.yaml"), "--out", str(tmp_path / "p.json")]) == 1
    assert "none.yaml" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "words"),
    [
        (["--initial-guesses", "0"], "--initial-guesses = 0; must be in [1, 100]"),
        (["--speed", "0"], "--speed = 0.0; must be in [0.01, 50.0] m/s"),
        (["--acceleration", "nan"], "--acceleration = nan; must be in [0.01, 100.0] m/s^2"),
        (["--tilt", "20"], "--tilt = 20.0; must be in [0.01, 1.5] rad"),
    ],
)
def test_a_number_out_of_bounds_names_its_option(
    option: list[str], words: str, crossing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(crossing), "--out", str(tmp_path / "plan.json"), *option]) == 1
    assert capsys.readouterr().err == f"plan: {words}\n"
