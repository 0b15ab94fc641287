"""Files of commands: texts are written whole or not at all, and errors of the system name the file."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def write_text(text: str, file: Path) -> None:
    """Write a text in UTF-8, and create the folders above it; a full disk leaves what was there before.

    Devices and pipes, and files in folders that cannot be written, are written as they are.

    Raises:
        OSError: naming the file.
    """
    with naming_written(file):
        file.parent.mkdir(parents=True, exist_ok=True)
        if file.exists() and not (file.is_file() and os.access(file.resolve().parent, os.W_OK)):
            file.write_text(text, encoding="utf-8")
        else:
            _replace(file, text)


@contextmanager
def naming_written(file: Path) -> Iterator[None]:
    """Name the file in errors of the operating system that name none: those of writing to an open file."""
    try:
        yield
    except OSError as error:
        if error.filename is not None or error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(file)) from error


def _replace(file: Path, text: str) -> None:
    """Write a text beside a file, then put it in its place."""
    target = file.resolve()
    part = target.with_name(f"{target.name}.{os.getpid()}.part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(target)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(file)) from error
