"""Paths of bags: which paths are bags, their files of storage, and the name of the flight in one."""

from pathlib import Path

STORAGES = (".mcap", ".db3")
ROS1_SUFFIX = ".bag"
FILES = (*STORAGES, ROS1_SUFFIX)
"""Suffixes of bags that are one file."""


def is_bag(path: Path) -> bool:
    """Return whether a path looks like a bag, judged by its name or the files in its folder."""
    if path.is_dir():
        return (path / "metadata.yaml").exists() or bool(storage_files(path))
    return path.suffix in FILES


def flight_name(path: Path | str) -> str:
    """Return the name of the flight in a bag: its folder's, dots included, or its file's without suffix."""
    bag = Path(path)
    if not bag.name.strip("."):  # `.` and `..`
        bag = bag.resolve()
    return bag.stem if bag.suffix in FILES else bag.name


def storage_files(bag: Path) -> list[Path]:
    """Return the files of a bag in the order in which they were written; a file is its own."""
    if bag.is_file():
        return [bag]
    found = [file for file in bag.iterdir() if file.suffix in STORAGES]
    return sorted(found, key=lambda file: (len(file.name), file.name))  # _2 before _10
