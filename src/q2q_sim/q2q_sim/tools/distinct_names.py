"""Names of recordings in tables and pages."""

from collections.abc import Sequence
from pathlib import Path

from q2q_model.bag.storage.bag_path import flight_name


def distinct_names(paths: Sequence[Path]) -> list[str]:
    """Return a name for each path: its last part without suffix, or all of it where those are equal.

    Raises:
        ValueError: a path is given twice.
    """
    for place, path in enumerate(paths):
        if any(path.resolve() == other.resolve() for other in paths[:place]):
            raise ValueError(f"{path} is given twice: give each flight once")
    short = [flight_name(path) if path.is_dir() else path.stem for path in paths]
    return short if len(set(short)) == len(short) else [str(path) for path in paths]
