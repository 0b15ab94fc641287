"""Places to write to are refused while the command line is read, with the reason."""

import errno
import os
from pathlib import Path

import pytest

from q2q_model.commands.argument_types import output_file, output_folder
from q2q_model.commands.command_line import CommandLine


def made() -> CommandLine:
    line = CommandLine("tool", "Writes things.", "  tool --out folder")
    line.add_argument("--json", type=output_file, help="file")
    line.add_argument("--out", type=output_folder, help="folder")
    return line


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        (["--json", "{folder}"], "argument --json: {folder} is a folder; give a file"),
        (["--out", "{file}"], "argument --out: {file} is a file; give a folder"),
        (["--out", "/dev/null"], "argument --out: /dev/null is a file; give a folder"),
        (["--out", "/dev/null/a"], "argument --out: /dev/null is a file; it cannot hold a"),
        (["--json", "{file}/a/b.json"], "argument --json: {file} is a file; it cannot hold a/b.json"),
    ],
)
def test_a_place_that_cannot_be_written_is_refused_before_the_work(
    words: list[str], answer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file = tmp_path / "notes.txt"
    file.touch()
    with pytest.raises(SystemExit) as ended:
        made().parse_args([word.format(folder=tmp_path, file=file) for word in words])
    assert ended.value.code == 2
    assert capsys.readouterr().err == f"tool: {answer.format(folder=tmp_path, file=file)}; see --help\n"


@pytest.mark.parametrize(
    ("words", "there"), [(["--out", "{folder}/a/b"], "{folder}"), (["--json", "{file}"], "{file}")]
)
def test_a_place_without_permission_is_refused_before_the_work(
    words: list[str],
    there: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
):
    file = tmp_path / "notes.txt"
    file.touch()
    place = there.format(folder=tmp_path, file=file)
    monkeypatch.setattr(
        os, "access", lambda path, mode: mode == os.W_OK and str(path) != place
    )  # also for root
    with pytest.raises(SystemExit) as ended:
        made().parse_args([word.format(folder=tmp_path, file=file) for word in words])
    assert ended.value.code == 2
    assert f"{place} cannot be written (permission denied); give another place" in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--out", "--json"])
@pytest.mark.parametrize(
    ("code", "reason"), [(errno.ENAMETOOLONG, "file name too long"), (errno.EACCES, "permission denied")]
)
def test_a_place_that_cannot_be_looked_at_is_refused_before_the_work(
    option: str, code: int, reason: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a folder within one of another user, for which the system has an error in place of an answer."""

    def refuse(path: Path, **_: object) -> os.stat_result:
        raise OSError(code, os.strerror(code), str(path))

    monkeypatch.setattr(Path, "stat", refuse)
    with pytest.raises(SystemExit) as ended:
        made().parse_args([option, "closed/a"])
    assert ended.value.code == 2
    assert f"closed/a cannot be written ({reason}); give another place" in capsys.readouterr().err


def test_a_place_that_does_not_exist_yet_is_taken(tmp_path: Path):
    args = made().parse_args(["--json", f"{tmp_path}/a/b.json", "--out", f"{tmp_path}/c"])
    assert (args.json, args.out) == (tmp_path / "a" / "b.json", tmp_path / "c")
