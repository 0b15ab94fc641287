"""Data files shipped with a package, wherever the package is installed.

| installed by | folder |
|---|---|
| pip | `config/` in the package |
| colcon | `share/PACKAGE/config` of an ament prefix |
| nothing: source tree | `config/` next to the package |
"""

import os
from pathlib import Path

CONFIG = "config"


def shipped_folder(package: Path) -> Path:
    """Return the folder of the files shipped with a package, given the folder of its modules."""
    if (inside := package / CONFIG).is_dir():
        return inside
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix and (found := Path(prefix, "share", package.name, CONFIG)).is_dir():
            return found
    return package.parent / CONFIG


def shipped_or_given(name: str, named: Path) -> Path | None:
    """Return the shipped file that a name means, else the file at a path; None if there is neither.

    Args:
        name: name or path.
        named: file that is meant if it is a name.
    """
    if Path(name).name == name and named.is_file():
        return named
    return Path(name) if Path(name).is_file() else None
