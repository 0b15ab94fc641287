"""A wrong word is answered with the nearest right one, and help shows an example."""

import argparse
import os
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from q2q_model.commands import identify
from q2q_model.commands.argument_paths import require_apart
from q2q_model.commands.argument_types import whole_number
from q2q_model.commands.command_line import CommandLine, UsageError, nearest_word, run_command
from q2q_model.commands.ros_arguments import outside_ros


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


@pytest.mark.parametrize(
    ("given", "allowed"),
    [("-1", ">= 0"), ("x", ">= 0"), (f"{2**63}", r"in \[0, 9223372036854775807\]")],
)
def test_a_whole_number_out_of_bounds_is_answered_with_the_bound_that_it_breaks(given: str, allowed: str):
    assert whole_number(0)(f"{2**63 - 1}") == 2**63 - 1
    with pytest.raises(argparse.ArgumentTypeError, match=f"^{given}; must be an integer {allowed}$"):
        whole_number(0)(given)


def test_two_names_of_one_file_are_refused_and_of_one_device_are_not(tmp_path: Path):
    (tmp_path / "link").symlink_to(tmp_path / "a")
    with pytest.raises(UsageError, match=r"--json and --csv are both .*link: give each a file of its own"):
        require_apart({"--json": tmp_path / "a", "--out": None, "--csv": tmp_path / "link"})
    require_apart({"--json": tmp_path / "a", "--csv": tmp_path / "b"})
    require_apart({"--json": Path(os.devnull), "--csv": Path(os.devnull)})


def test_an_error_of_the_operating_system_is_its_path_and_words(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    def work(_: object) -> int:
        tmp_path.write_text("")
        return 0

    assert run_command(made(), lambda _: work, []) == 1
    assert capsys.readouterr().err == f"tool: {tmp_path}: Is a directory\n"


def test_notes_of_an_error_are_printed_before_it(capsys: pytest.CaptureFixture[str]) -> None:
    refusal = ValueError("nothing can be fitted")
    refusal.add_note("the first flight has a hole")

    def refuse(_: argparse.Namespace) -> int:
        raise refusal

    assert run_command(made(), lambda _: refuse, []) == 1
    assert capsys.readouterr().err == "tool: the first flight has a hole\ntool: nothing can be fitted\n"


def test_help_shows_the_example(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as ended:
        made().parse_args(["--help"])
    assert ended.value.code == 0
    assert "  tool --seed 3\n" in capsys.readouterr().out


def test_what_is_meant_for_ros_is_left_to_ros():
    own = ["a", "--seed", "1"]
    assert outside_ros([*own, "--ros-args", "-r", "x:=y"]) == own
    assert outside_ros(["a", "--ros-args", "-r", "x:=y", "--", "--seed", "1"]) == own
    assert outside_ros(["a"]) == ["a"]


def test_nothing_is_near_to_a_word_unlike_all():
    assert nearest_word(["--qqqqqq"], ["--seed", "--controller"]) == ""


def test_an_option_is_near_to_options_only_and_its_value_to_nothing():
    known = ["--lockstep", "wind", "state"]
    assert nearest_word(["--wind", "2"], known) == ""
    assert nearest_word(["--colour", "sttae"], known) == ""
    assert nearest_word(["sttae"], known) == "state"
    assert nearest_word(["lockstp"], known) == "--lockstep"


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


@pytest.mark.parametrize("lines", [1, 100_000])  # the first waits in the buffer until the end
@pytest.mark.parametrize("printed", ["print", "plain_console().print"])
def test_output_that_nobody_reads_ends_a_command_without_a_traceback(printed: str, lines: int):
    program = (
        "import sys; from q2q_model.commands.command_line import CommandLine, run_command\n"
        "from q2q_model.plain_console import plain_console\n"
        "sys.stdin.read()\n"
        f"work = lambda _: {printed}('line\\n' * {lines}) or 0\n"
        "sys.exit(run_command(CommandLine('tool', 'Does things.', 'tool'), lambda _: work, []))"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", program], **pipes) as process:
        assert process.stdout is not None
        process.stdout.close()  # as `| head` does once it has its lines
        process.stdout = None
        _, said = process.communicate(b"")
    assert process.returncode == 141
    assert said == b""


@pytest.mark.parametrize("printed", ["print", "plain_console().print"])
def test_a_standard_output_on_a_full_disk_is_named(printed: str):
    program = (
        "import sys; from q2q_model.commands.command_line import CommandLine, run_command\n"
        "from q2q_model.plain_console import plain_console\n"
        f"work = lambda _: {printed}('line') or 0\n"
        "sys.exit(run_command(CommandLine('tool', 'Does things.', 'tool'), lambda _: work, []))"
    )
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    command = ["sh", "-c", 'exec "$0" -c "$1" > /dev/full', sys.executable, program]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, env=buffered, check=False)
    assert (done.returncode, done.stderr) == (1, "tool: standard output: No space left on device\n")


def test_a_closed_standard_output_is_refused_before_the_work_and_closed_errors_are_dropped():
    program = (
        "import sys; from q2q_model.commands.command_line import CommandLine, run_command\n"
        "work = lambda _: print('document') or print('errors', file=sys.stderr) or 0\n"
        "sys.exit(run_command(CommandLine('tool', 'Does things.', 'tool'), lambda _: work, []))"
    )

    def run(closed: str) -> subprocess.CompletedProcess[str]:
        command = ["sh", "-c", f'exec "$0" -c "$1" {closed}', sys.executable, program]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    refused = run(">&-")
    assert (refused.returncode, refused.stdout) == (2, "")
    assert refused.stderr.startswith("tool: standard output is closed: redirect it")
    assert refused.stderr.count("\n") == 1
    dropped = run("2>&-")
    assert (dropped.returncode, dropped.stdout, dropped.stderr) == (0, "document\n", "")


@pytest.mark.parametrize("closed", ["2>&-", "<&- 2>&-"])
def test_a_process_that_a_command_starts_has_a_standard_error_where_that_of_the_command_is_closed(
    closed: str,
):
    program = (
        "import subprocess, sys; from q2q_model.commands.command_line import CommandLine, run_command\n"
        "code = 'import sys; print(1, file=sys.stderr); sys.exit(sys.stderr is None)'\n"
        "work = lambda _: subprocess.run([sys.executable, '-c', code]).returncode\n"
        "sys.exit(run_command(CommandLine('tool', 'Does things.', 'tool'), lambda _: work, []))"
    )
    command = ["sh", "-c", f'exec "$0" -c "$1" {closed}', sys.executable, program]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_output_in_an_encoding_that_lacks_a_letter_is_printed_all_the_same():
    program = (
        "from q2q_model.commands.command_line import CommandLine, run_command\n"
        "line = CommandLine('tool', 'Does things.', '  tool')\n"
        "raise SystemExit(run_command(line, lambda args: lambda args: print('effort [N\\xb2s]') or 3, []))"
    )
    command = [sys.executable, "-c", program]
    for coding in ("ascii", "ascii:surrogateescape"):
        ascii_only = os.environ | {"PYTHONIOENCODING": coding}
        done = subprocess.run(command, capture_output=True, text=True, env=ascii_only, check=False)
        assert (done.returncode, done.stdout, done.stderr) == (3, "effort [N?s]\n", "")


def test_a_path_that_is_not_utf8_is_printed_as_it_is_where_the_locale_can():
    program = (
        "import os\n"
        "from q2q_model.commands.command_line import CommandLine, run_command\n"
        "line = CommandLine('tool', 'Does things.', '  tool')\n"
        "path = os.fsdecode(b'd\\xe9mo.html')\n"
        "raise SystemExit(run_command(line, lambda args: lambda args: print(path, 'N\xb2s') or 3, []))"
    )
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONIOENCODING"}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, env=environment | {"LC_ALL": "C.UTF-8"}, check=False)
    assert (done.returncode, done.stdout) == (3, b"d\xe9mo.html N\xc2\xb2s\n"), done.stderr


def test_a_broken_pipe_to_another_process_is_reported(capsys: pytest.CaptureFixture[str]):
    def work(_: object) -> int:
        raise BrokenPipeError("the recorder has gone")

    assert run_command(made(), lambda _: work, []) == 1
    assert capsys.readouterr().err == "tool: the recorder has gone\n"


@pytest.mark.parametrize("given", ["nan", "inf", "0", "-0.1", "much"])
def test_a_threshold_that_is_no_number_above_zero_is_refused(given: str, capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as ended:
        identify.main(["bag", "--out", "model.q2q", f"--threshold={given}"])
    assert ended.value.code == 2
    assert f"argument --threshold: {given}; must be a finite number above 0" in capsys.readouterr().err
