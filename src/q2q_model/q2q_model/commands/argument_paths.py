"""Checks of the paths that the arguments of a command name."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from q2q_model.commands.command_line import UsageError


def require_existing(what: str, *paths: Path | None) -> None:
    """Raise ValueError for the first path that does not exist (None: not given); `what` names its kind."""
    for path in paths:
        if path is not None and not path.exists():
            raise ValueError(f"no {what} at {path}")


def require_apart(
    files: Mapping[str, Path | None], folders: Mapping[str, Path | None] = MappingProxyType({})
) -> None:
    """Raise UsageError if two of the files, named by their arguments, are the same; devices may be.

    It is raised, too, if a file is a folder that another argument asks for.
    """
    seen: dict[Path, str] = {}
    for name, path in files.items():
        if path is None or (path.exists() and not path.is_file()):
            continue
        other = seen.setdefault(path.resolve(), name)
        if other != name:
            raise UsageError(f"{other} and {name} are both {path}: give each a file of its own")
    needed = {name: path.resolve() for name, path in folders.items() if path}
    _require_no_folders(seen, needed | {name: path.parent for path, name in seen.items()})


def _require_no_folders(files: Mapping[Path, str], needed: Mapping[str, Path]) -> None:
    for name, folder in needed.items():
        for place in (folder, *folder.parents):
            if place in files:
                both = f"{files[place]} is the file {place}, which {name} needs as a folder"
                raise UsageError(f"{both}: give one of them another place")
