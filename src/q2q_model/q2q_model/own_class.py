"""Class of a user's, named as `module:Class`; its module is searched for in the current folder, too."""

import re
import sys
from importlib import import_module
from pathlib import Path

NAME = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


class OwnClassError(ValueError):
    """Error for a class that cannot be found, or is no class."""


def is_own_class(name: str) -> bool:
    """Return whether a name has the form `module:Class`; nothing is imported."""
    return NAME.fullmatch(name) is not None


def own_class(name: str) -> type[object]:
    """Import a module and return its class.

    Raises:
        OwnClassError: the name has another form, the module cannot be imported, or has no such class.
    """
    module, _, wanted = name.partition(":")
    if not module or not wanted or "/" in name:
        raise OwnClassError("is no name of a class: give module:Class")
    try:
        found = getattr(_imported(module), wanted, None)
    except (Exception, SystemExit) as error:
        raise OwnClassError(
            f"{module} cannot be imported ({error_line(error)}); give a module of this folder, {Path.cwd()}, "
            "or an installed one (PYTHONPATH is not searched where the set-up installed ROS)"
        ) from error
    if not isinstance(found, type):
        raise OwnClassError(f"{module} has no class {wanted}")
    return found


def error_line(error: BaseException) -> str:
    """Return kind and first line of an error of a user's class; numba's have many lines."""
    try:
        lines = str(error).strip().splitlines()
    except Exception:  # noqa: BLE001  of a user's error
        lines = []
    return ": ".join([type(error).__name__, *lines[:1]])


def _imported(module: str) -> object:
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)
    return import_module(module)
