"""Air files: a RoomAir with the flights it was learned from and the interval of each value.

A `.air` file is JSON and holds data only; a checksum detects a truncated, edited or damaged file. A term that
is null is switched off.

    {"format": "q2q-air", "version": 2, "checksum": "...",
     "air": {"jet": {"gaps_m": [...], "radii_m": [...], "push_mps2": [[...], ...], ...},
             "residual": {"floor_mps2": ..., "slope": ..., "time_s": ...}, "wind": null, ...,
             "flights": [...], "digests": [...], "intervals": {"residual.time_s": [low, high], ...}}}
"""

from pathlib import Path

from q2q_model.documents.checksummed_json import (
    ChecksummedFileError,
    FileFormat,
    decode_checksummed,
    encode_checksummed,
)
from q2q_model.documents.plain_values import PlainValueError, from_plain, to_plain
from q2q_model.documents.read_text import read_text
from q2q_model.documents.written_file import write_text
from q2q_sim.air.air_names import AirError
from q2q_sim.air.room_air import RoomAir

FORMAT = FileFormat(name="q2q-air", noun="q2q air", version=2, maker="learn_air")
"""Version 1 lacks the digests of flights."""


def save(path: Path, air: RoomAir) -> None:
    """Write an air file; raise AirError if a number is not finite."""
    write_text(encode(air), path)


def load(path: Path) -> RoomAir:
    """Return the air of a file.

    Raises:
        AirError: it cannot be read, is no air file, is damaged, or has an unknown term or a wrong value.
    """
    try:
        return decode(read_text(path))
    except ValueError as error:
        raise AirError(f"air file {path}: {error}") from error


def encode(air: RoomAir) -> str:
    """Return the file's text."""
    try:
        return encode_checksummed({"air": to_plain(air, "air")}, FORMAT)
    except PlainValueError as error:
        raise AirError(str(error)) from error


def decode(text: str) -> RoomAir:
    """Return the air of a file's text; raise AirError if it is not valid."""
    try:
        return from_plain(RoomAir, decode_checksummed(text, FORMAT).get("air"), "air")
    except (ChecksummedFileError, PlainValueError) as error:
        raise AirError(str(error)) from error
