"""Files of commands: texts are written whole or not at all, and errors of the system name the file."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import copymode
from tempfile import TemporaryDirectory


def write_text(text: str, file: Path) -> None:
    """Write a text in UTF-8, and create the folders above it; a full disk leaves what was there before.

    A file keeps its permissions, and a link stays a link. What no other file can replace (`_is_replaceable`),
    as devices and mount points, is written in place.

    Raises:
        OSError: naming the file.
    """
    with naming_written(file):
        file.parent.mkdir(parents=True, exist_ok=True)
        if not (_is_replaceable(file) and _replace(file, text)):
            file.write_text(text, encoding="utf-8")


@contextmanager
def naming_written(file: Path) -> Iterator[None]:
    """Name the file in errors of the operating system that name none: those of writing to an open file."""
    try:
        yield
    except OSError as error:
        if error.filename is not None or error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(file)) from error


def _is_replaceable(file: Path) -> bool:
    """Return whether a file is absent, or an ordinary one of one name, of this user and writable."""
    if not file.exists():
        return True
    found, writable = file.stat(), (os.access(one, os.W_OK) for one in (file, file.resolve().parent))
    return file.is_file() and found.st_nlink == 1 and found.st_uid == os.geteuid() and all(writable)


def _replace(file: Path, text: str) -> bool:
    """Write a text beside a file, then put it in its place; return False where the file is a mount point."""
    target = file.resolve()
    try:
        with TemporaryDirectory(prefix=".", dir=target.parent) as folder:
            part = Path(folder) / "text"
            part.write_text(text, encoding="utf-8")
            if target.exists():
                copymode(target, part)
            part.replace(target)
    except OSError as error:
        if error.errno == errno.EBUSY:
            return False
        raise OSError(error.errno, error.strerror, str(file)) from error
    return True
