"""Names of airs, checked without the imports that airs need."""

import os
import re
from pathlib import Path

SUFFIX = ".air"
LAWS = ("none", "paper", "measured")
"""Wake laws (q2q_sim.air.wake_laws)."""
MADE = ("ring", "heavy_tailed", "bent", "meandering")
"""Airs of other families than the models (q2q_sim.air.made_airs)."""
IN_SHARE = Path("share", "q2q_sim", "config")
IN_SOURCE = Path(__file__).resolve().parents[2] / "config"
OWN = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")
"""module:Class."""


class AirError(ValueError):
    """Error for an air that does not exist, is not valid, or gives no valid push."""


def check_air(name: str) -> None:
    """Raise AirError if there is neither an air nor a file of this name; `module:Class` is not imported."""
    if name not in (*LAWS, *MADE) and not OWN.fullmatch(name):
        air_path(name)


def air_path(name: str) -> Path:
    """Return the file of an air, given by the name of a shipped one or by its path.

    Raises:
        AirError: the air does not exist.
    """
    shipped = shipped_airs()
    named = shipped / f"{name}{SUFFIX}"
    if Path(name).name == name and named.is_file():
        return named
    if Path(name).is_file():
        return Path(name)
    known = ", ".join((*LAWS, *MADE, *sorted(path.stem for path in shipped.glob(f"*{SUFFIX}"))))
    raise AirError(f"no air {name!r}: give one of {known}, a {SUFFIX} file, or module:Class")


def shipped_airs() -> Path:
    """Return the folder of the shipped `.air` files: in an ament prefix, else in the source tree."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix and (found := Path(prefix) / IN_SHARE).is_dir():
            return found
    return IN_SOURCE
