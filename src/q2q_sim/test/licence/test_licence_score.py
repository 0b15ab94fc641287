"""A score judges the programs that it was asked for, or refuses to judge any."""

from pathlib import Path

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from q2q_sim.commands.licence import main
from q2q_sim.licence import licence_command
from q2q_sim.licence.licence_score import LicenceScore, ScoredProgram


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder of two sound programs and a buggy one, each of which passes without a flight."""
    for name in ("sound/hop", "sound/swarm_steps", "buggy/no_landing"):
        file = tmp_path / f"{name}.py"
        file.parent.mkdir(exist_ok=True)
        file.write_text("")
    (tmp_path / "programs.toml").write_text("[swarm_steps]\nroom = [4.0, 4.0, 2.0]\n")

    def passes(one: ScoredProgram, _: int, __: int) -> LicenceScore:
        return LicenceScore(one, True, f"room {one.settings.room[0]:g} m", 1, 0.0)  # noqa: FBT003

    monkeypatch.setattr(licence_command, "score_program", passes)
    return tmp_path


def test_the_programs_of_a_folder_are_judged_all_or_those_named(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--score", str(folder)]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "right  hop: room 6 m",
        "right  swarm_steps: room 4 m",
        "WRONG  no_landing: room 6 m",
        "2 of 3 programs judged correctly",
    ]
    assert main(["--score", str(folder), "--only", "swarm_steps"]) == 0
    assert capsys.readouterr().out.endswith("\n1 of 1 programs judged correctly\n")


@pytest.mark.parametrize(("only", "message"), [
    (["swarm_step"], "swarm_step (did you mean swarm_steps?)"),
    (["x", "no_land"], "x (choose one of hop, swarm_steps, no_landing), no_land (did you mean no_landing?)"),
])  # fmt: skip
def test_a_name_that_no_program_has_is_refused_before_any_is_judged(
    folder: Path, only: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--score", str(folder), "--only", *only]) == 2
    assert capsys.readouterr() == ("", f"licence: --only: {folder} has no program {message}\n")


def test_a_folder_without_programs_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    needed = "no program in it; must have .py files in sound or buggy"
    for _ in range(2):
        assert main(["--score", str(tmp_path)]) == 2
        assert capsys.readouterr() == ("", f"licence: --score {tmp_path}: {needed}\n")
        (tmp_path / "programs.toml").touch()
