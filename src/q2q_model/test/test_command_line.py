"""A wrong word is answered with the nearest right one, and help shows an example."""

import warnings

import pytest

from q2q_model.commands.command_line import CommandLine, nearest, run_command, without_ros


def made() -> CommandLine:
    line = CommandLine("tool", "Does things.", "  tool --seed 3")
    line.add_argument("--seed", type=int, help="seed")
    line.add_argument("--controller", choices=("pid", "mpc"), help="who")
    return line


@pytest.mark.parametrize(
    ("words", "hint"),
    [(["--sede", "3"], "--seed"), (["--contoller=pid"], "--controller"), (["--controller", "pdi"], "pid")],
)
def test_a_misspelt_word_is_answered_with_the_nearest_one(
    words: list[str], hint: str, capsys: pytest.CaptureFixture[str]
):
    with pytest.raises(SystemExit) as ended:
        made().parse_args(words)
    assert ended.value.code == 2
    output = capsys.readouterr().err
    assert f"did you mean {hint}?" in output
    assert output.count("\n") == 1


def test_a_wrong_number_gets_no_hint(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit):
        made().parse_args(["--seed", "x"])
    output = capsys.readouterr().err
    assert "invalid int value" in output
    assert "did you mean" not in output


def test_help_shows_the_example(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as ended:
        made().parse_args(["--help"])
    assert ended.value.code == 0
    assert "  tool --seed 3\n" in capsys.readouterr().out


def test_what_is_meant_for_ros_is_left_to_ros():
    assert without_ros(["a", "--seed", "1", "--ros-args", "-r", "x:=y"]) == ["a", "--seed", "1"]
    assert without_ros(["a"]) == ["a"]


def test_nothing_is_near_to_a_word_unlike_all():
    assert nearest(["--qqqqqq"], ["--seed", "--controller"]) == ""


@pytest.mark.filterwarnings("always")
def test_a_warning_is_one_line_of_the_program_and_changes_nothing_beyond_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def work(_: object) -> int:
        warnings.warn("a topic is missing", stacklevel=1)
        return 0

    before = warnings.showwarning, warnings.formatwarning
    assert run_command(CommandLine("identify", None, "identify"), lambda _: work, []) == 0
    assert capsys.readouterr().err == "identify: warning: a topic is missing\n"
    assert (warnings.showwarning, warnings.formatwarning) == before
