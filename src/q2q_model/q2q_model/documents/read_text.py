"""Text of a file that a user names."""

from pathlib import Path


def read_text(path: Path) -> str:
    """Return the text of a file in UTF-8; raise ValueError with why it cannot be read, without its path."""
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise ValueError(f"cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise ValueError(f"cannot be read (not UTF-8: {error.reason})") from error
