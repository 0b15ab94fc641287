"""Check the name of an interaction model before anything is imported that could read it."""

import os
from pathlib import Path

from q2q_model.files.model_names import model_path

IN_SHARE = Path("share", "q2q_model", "config")
IN_SOURCE = Path(__file__).resolve().parents[2] / "config"


def check_model(name: str) -> None:
    """Raise ModelFileError where there is no model of this name, shipped or a file."""
    model_path(name, shipped_models())


def shipped_models() -> Path:
    """Return the folder of the shipped `.q2q` files: that of the first ament prefix that has one."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix and (found := Path(prefix) / IN_SHARE).is_dir():
            return found
    return IN_SOURCE
