"""Tests of a node's command line: unknown words are refused, options become parameters."""

import pytest

from q2q_model.commands.node_command_line import NodeCommandLine


@pytest.fixture
def line() -> NodeCommandLine:
    return NodeCommandLine("q2q_control", "radio", "Radio node.", {"dry_run": "send nothing"})


def test_an_option_is_its_parameter_and_the_rest_is_for_ros(line: NodeCommandLine) -> None:
    ros = ["--ros-args", "-p", "mode:=setpoint"]
    assert line.for_ros([]) == []
    assert line.for_ros(ros) == ros
    dry = ["--ros-args", "-p", "dry_run:=true"]
    assert line.for_ros(["--dry-run", *ros]) == ["--dry-run", *ros, *dry]
    assert line.for_ros([*ros, "--", "--dry-run"]) == [*ros, "--", "--dry-run", *dry]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--dryrun"], "unrecognized arguments: --dryrun; did you mean --dry-run?"),
        (["--law", "safe"], "unrecognized arguments: --law safe"),
        (["-p", "law:=safe"], "-p law:=safe; parameters follow --ros-args: --ros-args -p name:=value"),
    ],
)
def test_an_unknown_word_is_refused(
    words: list[str], message: str, line: NodeCommandLine, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        line.for_ros([*words, "--ros-args", "-p", "vehicles:=['cf1']"])
    with pytest.raises(SystemExit):
        line.for_ros(["--ros-args", "-p", "vehicles:=['cf1']", "--", *words])
    assert ended.value.code == 2
    error = capsys.readouterr().err
    assert error.startswith("radio: ")
    assert message in error
    first, second = error.splitlines()
    assert first == second


def test_help_names_the_options_and_how_parameters_are_given(
    line: NodeCommandLine, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        line.for_ros(["--help"])
    assert ended.value.code == 0
    shown = capsys.readouterr().out
    assert "Radio node." in shown
    assert "--dry-run" in shown
    assert "ros2 run q2q_control radio --ros-args -p name:=value" in shown
