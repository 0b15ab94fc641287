"""Model files: an interaction model with its zone, gains, training flights and scores.

A `.q2q` file is JSON and holds data only: its `type` entries choose among the classes named here, and nothing
in it is executed. A SHA-256 checksum over the other entries detects a truncated, edited or damaged file.

    {"format": "q2q-model", "version": 4, "checksum": "...",
     "model": {"type": "jet", "parameters": {...}},
     "zone": {"type": "cylinder", "parameters": {"eps": 0.1, "d": 1.1}},
     "gains": {"k_p": ..., "k_d": ..., ...} | null,
     "fit": {...} | null,
     "residual": {...}}                 absent if unknown
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from q2q_model.documents.checksummed_json import FileFormat, decode_checksummed, encode_checksummed
from q2q_model.documents.plain_values import Plain, PlainValueError, from_plain, to_plain
from q2q_model.documents.read_text import read_text
from q2q_model.documents.written_file import write_text
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.envelope_network import EnvelopeNetwork
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.downwash.jet import Jet
from q2q_model.downwash.level_set import LevelSet, level_set
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.geometry.zone import Cylinder, Ellipsoid, Zone
from q2q_model.model_files.model_bounds import check_model
from q2q_model.model_files.model_names import ModelFileError
from q2q_model.vehicle.altitude_loop import AltitudeLoop

FORMAT = FileFormat(name="q2q-model", noun="q2q model", version=4, maker="identify")
"""Version 1 lacks a jet's std_floor, version 2 its velocity_share, loading and absorption, version 3 the
digests of flights: their defaults."""

MODELS: Mapping[str, type[NoInteraction | Jet | EnvelopeNetwork]] = {
    "none": NoInteraction,
    "jet": Jet,
    "envelope_network": EnvelopeNetwork,
}
ZONES: Mapping[str, type[Cylinder | Ellipsoid]] = {"cylinder": Cylinder, "ellipsoid": Ellipsoid}
LEVEL_SET = "level_set"
"""Type of a zone stored by its threshold alone; its table is computed from the model."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class RoleScores:
    """Score for each role; None where there were no such samples."""

    lower: float | None = None
    upper: float | None = None


@dataclass(frozen=True, slots=True)
class Fit:
    """Training flights and scores of a model."""

    method: str
    flights: tuple[str, ...]
    held_out: tuple[str, ...] = ()
    train_mse_m2: RoleScores = field(default_factory=RoleScores)
    """Mean square error of the altitude trajectories [m^2], loss (16) over samples."""
    heldout_mse_m2: RoleScores = field(default_factory=RoleScores)
    heldout_r2: RoleScores = field(default_factory=RoleScores)
    digests: tuple[str, ...] = ()
    """Digests of the flights, by which copies of other names are known (flights.duplicates.same_flight)."""


@dataclass(frozen=True, slots=True)
class ModelFile:
    """Contents of a model file."""

    interaction: InteractionModel
    zone: Zone = field(default_factory=Cylinder)
    gains: AltitudeLoop | None = None
    fit: Fit | None = None
    residual: ResidualProcess | None = None


def save(path: Path, content: ModelFile) -> None:
    """Write a model file; create the folders above it.

    Raises:
        ModelFileError: a number is not finite, the class of the model or zone is not supported, or `load`
            would refuse the file.
    """
    text = encode(content)
    try:
        decode(text)
    except ValueError as error:
        raise ModelFileError(f"model file {path}: {error}") from error
    write_text(text, path)


def load(path: Path) -> ModelFile:
    """Return the contents of a model file.

    Raises:
        ModelFileError: it cannot be read, is no model file, is damaged, or has a value out of bounds.
    """
    try:
        return decode(read_text(path))
    except ValueError as error:
        raise ModelFileError(f"model file {path}: {error}") from error


def encode(content: ModelFile) -> str:
    """Return the file's text."""
    try:
        body: dict[str, Plain] = {
            "model": _tag(content.interaction, MODELS, "model"),
            "zone": _plain_zone(content.zone),
            "gains": to_plain(content.gains, "gains"),
            "fit": to_plain(content.fit, "fit"),
        }
        if content.residual is not None:
            body["residual"] = to_plain(content.residual, "residual")
    except PlainValueError as error:
        raise ModelFileError(str(error)) from error
    return encode_checksummed(body, FORMAT)


def decode(text: str) -> ModelFile:
    """Return the contents of a file's text; raise ModelFileError if it is not valid."""
    try:
        body = decode_checksummed(text, FORMAT)
        residual = body.get("residual")
        model = from_plain(*_tagged(body["model"], MODELS, "model"))
        check_model(model)
        return ModelFile(
            interaction=model,
            zone=_read_zone(body["zone"], model),
            gains=None if body["gains"] is None else from_plain(AltitudeLoop, body["gains"], "gains"),
            fit=None if body["fit"] is None else from_plain(Fit, body["fit"], "fit"),
            residual=None if residual is None else from_plain(ResidualProcess, residual, "residual"),
        )
    except KeyError as error:
        raise ModelFileError(f"entry {error} is missing") from error
    except ValueError as error:
        raise ModelFileError(str(error)) from error


def _tag(value: object, known: Mapping[str, type], path: str) -> Plain:
    for name, cls in known.items():
        if isinstance(value, cls):
            return {"type": name, "parameters": to_plain(value, path)}
    raise ModelFileError(f"a {type(value).__name__} cannot be stored; choose one of {', '.join(known)}")


def _tagged(plain: Plain, known: Mapping[str, type[T]], path: str) -> tuple[type[T], Plain, str]:
    """Return the class that an entry names, its parameters and their path."""
    if not isinstance(plain, dict) or not isinstance(name := plain.get("type"), str) or name not in known:
        shown = plain.get("type") if isinstance(plain, dict) else plain
        raise ModelFileError(f"{path}.type is {shown!r}: choose one of {', '.join(known)}")
    return known[name], plain.get("parameters"), f"{path}.parameters"


def _plain_zone(zone: Zone) -> Plain:
    if isinstance(zone, LevelSet):
        return {"type": LEVEL_SET, "parameters": {"threshold": zone.threshold}}
    return _tag(zone, ZONES, "zone")


@dataclass(frozen=True, slots=True)
class _Threshold:
    threshold: float


def _read_zone(plain: Plain, model: InteractionModel) -> Zone:
    if isinstance(plain, dict) and plain.get("type") == LEVEL_SET:
        parameters = from_plain(_Threshold, plain.get("parameters"), "zone.parameters")
        return level_set(model, parameters.threshold)
    return from_plain(*_tagged(plain, ZONES, "zone"))
