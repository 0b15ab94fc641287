"""A file that cannot be written is named, also if the disk fills up while it is written."""

import errno
from collections.abc import Callable
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
