"""Folder of a firmware app: the C sources shipped here, and the header of its model."""

from pathlib import Path

from q2q_control.onboard.model_header import AppRates, model_header
from q2q_model.documents.written_file import write_text
from q2q_model.model_files.model_file import ModelFile
from q2q_model.vehicle.constants import Vehicle

SOURCES = Path(__file__).parent / "firmware_app"
HEADER = "q2q_model.h"
CORE = ("q2q_app.c", "q2q_correction.c", "q2q_downwash.c", "q2q_track.c")
"""Sources that need no firmware."""


def write_app(folder: Path, file: ModelFile, vehicle: Vehicle, rates: AppRates | None = None) -> list[Path]:
    """Write a firmware app and return its files.

    Raises:
        UnsupportedModelError: the model is not a jet; nothing is written.
        AppMemoryError: the app does not fit into a vehicle; nothing is written.
        FileExistsError: the folder is not empty; nothing is written.
    """
    header = model_header(file, vehicle, rates)
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise FileExistsError(f"{folder} is not an empty folder: name a new one, or remove it first")
    written = {HEADER: header}
    written |= {one.name: one.read_text(encoding="utf-8") for one in sorted(SOURCES.iterdir())}
    for name, text in written.items():
        write_text(text, folder / name)
    return [folder / name for name in written]
