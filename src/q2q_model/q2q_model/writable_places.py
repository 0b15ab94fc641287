"""Places to write to, checked before the work whose result goes there; missing folders may be created."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

STDOUT = Path("/dev/stdout")
"""File that is standard output: the value of `--json` without a file. (`-` is a file of that name.)"""


def writable_file(path: Path) -> Path:
    """Return the path of a file to write.

    Raises:
        ValueError: it is a folder, is to lie in a file, or cannot be written.
    """
    with _refusing(path):
        if path.is_dir():
            raise ValueError(f"{path} is a folder; give a file")
        return _permitted(path)


def writable_folder(path: Path) -> Path:
    """Return the path of a folder to write to.

    Raises:
        ValueError: it is a file, is to lie in a file, or cannot be written.
    """
    with _refusing(path):
        if path.exists() and not path.is_dir():
            raise ValueError(f"{path} is a file; give a folder")
        return _permitted(path)


@contextmanager
def _refusing(path: Path) -> Iterator[None]:
    """Raise ValueError for a path that the system refuses: too long, or in a folder closed to this user."""
    try:
        yield
    except OSError as error:
        reason = str(error.strerror).lower()
        raise ValueError(f"{path} cannot be written ({reason}); give another place") from error


def _permitted(path: Path) -> Path:
    there = next(one for one in (path, *path.parents) if one.exists())
    if there != path and not there.is_dir():
        raise ValueError(f"{there} is a file; it cannot hold {path.relative_to(there)}")
    if not os.access(there, os.W_OK):
        raise ValueError(f"{there} cannot be written (permission denied); give another place")
    return path
