"""Find interaction models by name: those shipped with the package, installed or in the source tree."""

import os
from pathlib import Path

from q2q_model.model_file import ModelFile, resolve

IN_SHARE = Path("share", "q2q_model", "config")
IN_SOURCE = Path(__file__).resolve().parents[2] / "config"


def find_model(name: str) -> ModelFile:
    """Return the model called "none", a shipped one by its name, or one by its path.

    Raises:
        ModelFileError: there is no such model, or its file cannot be used.
    """
    return resolve(name, shipped_models())


def shipped_models() -> Path:
    """Return the folder of the shipped `.q2q` files: that of the first ament prefix that has one."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix and (found := Path(prefix) / IN_SHARE).is_dir():
            return found
    return IN_SOURCE
