"""Check of an interaction model's name, cheap enough to run before heavy imports."""

from pathlib import Path

from q2q_model.files.model_names import model_path
from q2q_model.files.shipped_folder import shipped_folder


def check_model(name: str) -> None:
    """Raise ModelFileError if no shipped model or file has this name."""
    model_path(name, shipped_models())


def shipped_models() -> Path:
    """Return the folder of the shipped `.q2q` files."""
    return shipped_folder(Path(__file__).resolve().parents[1])
