"""A text is written whole, or the file stays as it was; a file that cannot be written is named."""

import errno
import os
import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

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


@contextmanager
def full_after(size: int) -> Iterator[None]:
    """Let this process write no file beyond a size [bytes], as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


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
