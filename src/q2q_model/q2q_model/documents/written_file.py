"""Files that commands write: an error of the operating system names the file, also where the disk is full."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def write_text(text: str, file: Path) -> None:
    """Write a text in UTF-8.

    Raises:
        OSError: naming the file.
    """
    with naming_written(file):
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
