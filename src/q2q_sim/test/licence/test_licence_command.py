"""The command line of the licence: its options, then those of the program."""

import shlex
from argparse import Namespace
from pathlib import Path

import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from q2q_sim.commands.licence import EXAMPLE, main
from q2q_sim.licence import licence_command


@pytest.fixture
def judged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Namespace]:
    """Return the command lines accepted, in a folder that has the files of the example."""
    accepted = list[Namespace]()

    def accept(args: Namespace) -> int:
        accepted.append(args)
        return 0

    monkeypatch.setattr(licence_command, "judge_program", accept)
    monkeypatch.setattr(licence_command, "score_programs", accept)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "test/licence_scripts").mkdir(parents=True)
    for name in ("my_flight.py", "pair.py", "swarm.py", "crazyflies.yaml"):
        (tmp_path / name).touch()
    return accepted


def test_the_example_of_the_help_is_accepted_line_by_line(judged: list[Namespace]) -> None:
    for line in EXAMPLE.splitlines():
        assert main(shlex.split(line)[1:]) == 0
    first, pair, swarm, score = judged
    assert (first.script, first.arguments) == (Path("my_flight.py"), [])
    assert (pair.script, pair.arguments) == (Path("pair.py"), ["--speed", "0.5"])
    assert (pair.start, pair.junit) == ([[0.0, -0.5, 0.0], [0.0, 0.5, 90.0]], Path("licence.xml"))
    assert (swarm.script, swarm.crazyflies) == (Path("swarm.py"), Path("crazyflies.yaml"))
    assert (score.script, score.score) == (None, Path("test/licence_scripts"))


@pytest.mark.parametrize(("line", "arguments"), [
    ("pair.py 0.5 left", ["0.5", "left"]),
    ("pair.py 0.5 --seed 3 -- --seed 4", ["0.5", "--seed", "4"]),
    ("pair.py --seed 3 -- --help -- -1", ["--help", "--", "-1"]),
    ("--seed 3 -- pair.py --seed 4", ["--seed", "4"]),
    ("--seed 3 pair.py --", []),
])  # fmt: skip
def test_words_after_the_first_dashes_are_the_program_s(
    judged: list[Namespace], line: str, arguments: list[str]
) -> None:
    assert main(shlex.split(line)) == 0
    (one,) = judged
    assert (one.script, one.arguments) == (Path("pair.py"), arguments)
    assert one.seed == (3 if "--seed 3" in line else 0)


def test_a_score_takes_no_program(judged: list[Namespace], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["--score", "test/licence_scripts", "--", "pair.py"])
    assert (left.value.code, judged) == (2, [])
    message = "licence: give either a program or --score FOLDER; see --help\n"
    assert capsys.readouterr().err == message
