"""Check of an interaction model's name, cheap enough to run before heavy imports."""

import os
from pathlib import Path

from q2q_model.files.model_names import model_path

IN_SHARE = Path("share", "q2q_model", "config")
IN_SOURCE = Path(__file__).resolve().parents[2] / "config"


def check_model(name: str) -> None:
    """Raise ModelFileError if no shipped model or file has this name."""
    model_path(name, shipped_models())


def shipped_models() -> Path:
    """Return the folder of the shipped `.q2q` files: in an ament prefix, else in the source tree."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix and (found := Path(prefix) / IN_SHARE).is_dir():
            return found
    return IN_SOURCE
