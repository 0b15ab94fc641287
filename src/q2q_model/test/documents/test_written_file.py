"""A text is written whole, or the file stays as it was; a file that cannot be written is named."""

import errno
import os
import stat
from collections.abc import Callable
from pathlib import Path

import pytest
from full_disk import full_after

from q2q_model.documents.json_file import write_json
from q2q_model.documents.written_file import naming_written, write_text

FULL = Path("/dev/full")
"""Linux: every write to it fails as on a full disk."""


@pytest.mark.parametrize("write", [lambda: write_text("words", FULL), lambda: write_json({"a": 1}, FULL)])
def test_a_full_disk_names_the_file(write: Callable[[], None]) -> None:
    with pytest.raises(OSError, match="No space left on device: '/dev/full'") as raised:
        write()
    assert (raised.value.errno, raised.value.filename) == (errno.ENOSPC, "/dev/full")


def test_a_name_that_the_error_has_is_kept(tmp_path: Path) -> None:
    inner = tmp_path / "absent" / "inner.txt"
    with pytest.raises(FileNotFoundError) as raised, naming_written(tmp_path / "outer.txt"):
        inner.write_text("words")
    assert raised.value.filename == str(inner)


def test_a_text_is_written_in_utf_8(tmp_path: Path) -> None:
    write_text("1 N²s\n", tmp_path / "text")
    assert (tmp_path / "text").read_bytes() == b"1 N\xc2\xb2s\n"


@pytest.mark.parametrize("mode", [0o600, 0o644, 0o755])
def test_a_file_keeps_its_permissions(mode: int, tmp_path: Path) -> None:
    file = tmp_path / "numbers.json"
    file.write_text("old")
    file.chmod(mode)
    write_text("new", file)
    assert (stat.S_IMODE(file.stat().st_mode), file.read_text()) == (mode, "new")


def test_a_new_file_has_the_permissions_of_others_that_are_opened(tmp_path: Path) -> None:
    (tmp_path / "opened").write_text("")
    write_text("new", tmp_path / "written")
    assert (tmp_path / "written").stat().st_mode == (tmp_path / "opened").stat().st_mode


def test_a_file_of_two_names_keeps_both(tmp_path: Path) -> None:
    (tmp_path / "one").write_text("old")
    (tmp_path / "two").hardlink_to(tmp_path / "one")
    write_text("new", tmp_path / "one")
    assert (tmp_path / "two").read_text() == "new"


def test_a_file_that_may_not_be_written_is_not_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is opened in place, which the system refuses; not to root, whose rights are denied here."""
    file = tmp_path / "numbers.json"
    file.write_text("old")
    before = file.stat().st_ino
    monkeypatch.setattr(os, "access", lambda path, _mode: Path(path) != file)
    write_text("new", file)
    assert file.stat().st_ino == before


def test_a_mount_point_is_written_in_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "numbers.json"
    file.write_text("old")
    monkeypatch.setattr(Path, "replace", raising(OSError(errno.EBUSY, "Device or resource busy")))
    write_text("new", file)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {file.name: "new"}


def test_an_interrupt_leaves_what_was_there_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "numbers.json"
    file.write_text("old")
    monkeypatch.setattr(Path, "replace", raising(KeyboardInterrupt()))
    with pytest.raises(KeyboardInterrupt):
        write_text("new", file)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {file.name: "old"}


def test_the_longest_name_is_written_and_a_longer_one_named(tmp_path: Path) -> None:
    longest = tmp_path / ("x" * 255)
    write_text("new", longest)
    assert longest.read_text() == "new"
    with pytest.raises(OSError, match=f"File name too long: '{longest}x'"):
        write_text("new", tmp_path / ("x" * 256))


def raising(error: BaseException) -> Callable[..., None]:
    """Return a function that raises an error."""

    def raise_it(*_: object, **__: object) -> None:
        raise error

    return raise_it


@pytest.mark.parametrize("before", [None, "old"])
def test_a_disk_that_is_full_leaves_what_was_there_before(before: str | None, tmp_path: Path) -> None:
    file = tmp_path / "numbers.json"
    if before is not None:
        file.write_text(before)
    with full_after(4), pytest.raises(OSError, match=str(file)):
        write_text("longer than four bytes", file)
    left = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert left == ({} if before is None else {file.name: before})


def test_a_link_stays_a_link_and_a_pipe_a_pipe(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write_text("new", tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_text() == "new"
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_text("new", tmp_path / "pipe")
    assert os.read(reader, 99) == b"new"
    os.close(reader)
