"""Interaction models: identified from flights, loaded and saved."""

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from threadpoolctl import threadpool_limits

from q2q.argument_checks import check_positive
from q2q.checked_model import CheckedModel
from q2q_model.downwash.interaction_model import InteractionModel
from q2q_model.flights.units_and_frames.frame_notes import axis_notes
from q2q_model.identification.identification import Identification, ProcedureParams
from q2q_model.identification.identification import identify as identify_recordings
from q2q_model.model_files import model_file
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import MODELS, ModelFile
from q2q_model.recordings.recordings_of_bags import topic_map
from q2q_model.recordings.recordings_of_paths import recordings_of_paths
from q2q_model.recordings.vehicle_of_flights import vehicle_of_flights

ModelChoice = str | Path | InteractionModel | ModelFile | Identification
"""Interaction model, with or without zone and gains, its name or file, or an identification."""


def identify(
    bags: Path | str | Sequence[Path | str],
    *,
    model_type: Literal["auto", "jet", "envelope_network"] = "auto",
    vehicle: str = "",
    threshold: float = 0.1,
    topics: Path | str | None = None,
) -> Identification:
    """Return gains, zone and interaction model of recorded flights, with scores on held-out ones.

    Args:
        bags: rosbag2 bags and tables (.parquet, .csv), one per flight, or folders of them; two or more for a
            held-out score, or the only one.
        model_type: "auto" selects by held-out error.
        vehicle: name of the vehicle; empty takes that of the bags' metadata, else the default.
        threshold: downwash on the boundary of the learned zone [m/s^2].
        topics: topic map (YAML) of bags of other software; None for bags of q2q.

    Repairs of damaged bags, a vehicle that had to be assumed, and flights whose z seems not to be up, are
    warnings.

    Raises:
        BagError: a bag cannot be read.
        TypeError, ValueError: an argument that is not allowed, no bag, a table that cannot be read, or
            flights that lack data that a step needs; the message says what is allowed, or what to record.
    """
    check_positive("threshold", threshold, "m/s^2")
    if not isinstance(bags, str | Path | Iterable):
        raise TypeError(f"bags = {bags!r}; must be the folder of a bag, or several")
    if isinstance(bags, bytes):
        raise TypeError(f"bags = {bags!r}; must be text or a Path, not bytes")
    paths = [Path(bag) for bag in ([bags] if isinstance(bags, str | Path) else bags)]
    if not paths:
        raise ValueError("no bags: give the folder of a recorded flight, or several")
    flown = vehicle_of_flights(paths, vehicle)
    recordings, notes = recordings_of_paths(paths, topic_map(Path(topics) if topics else None))
    doubts = (note for one in recordings for note in axis_notes(one.flight))
    for note in filter(None, (flown.note, *notes, *doubts)):
        warnings.warn(note, stacklevel=2)
    params = ProcedureParams(model_type, threshold, flown.vehicle)
    with threadpool_limits(1, user_api="blas"):  # more threads are slower on small matrices
        return identify_recordings(recordings, params, _ignore_step)


def load_model(chosen: ModelChoice) -> ModelFile:
    """Return an interaction model with its zone and gains.

    Args:
        chosen: "none", a shipped name, as "measured_law" (fitted to real flights), the path of a .q2q file,
            or a model.

    Raises:
        ModelFileError: the model does not exist, or its file is not valid.
        TypeError: it is no model, as a class in place of an object of it.
    """
    if isinstance(chosen, str | Path):
        return find_model(str(chosen))
    if isinstance(chosen, Identification):
        return chosen.file
    file = chosen if isinstance(chosen, ModelFile) else ModelFile(interaction=chosen)
    if isinstance(file.interaction, type) or not isinstance(file.interaction, InteractionModel):
        raise TypeError(
            f"no model {file.interaction!r}: give a name, the path of a .q2q file, a model of "
            "q2q.load_model or q2q.identify, or an object like q2q.InteractionModel"
        )
    return file


def flown_model(chosen: ModelChoice) -> ModelFile:
    """Return the model of a flight or a plan; every output of a class of one's own is checked.

    Raises:
        ModelFileError, TypeError: as `load_model`.
        ModelOutputError: a class of one's own returns something that cannot be flown with.
    """
    file = load_model(chosen)
    if isinstance(file.interaction, tuple(MODELS.values())):
        return file
    return replace(file, interaction=CheckedModel(file.interaction))


def save_model(chosen: ModelChoice, path: Path | str) -> Path:
    """Write a model as a .q2q file, which nodes and command lines read too; return its path.

    Raises:
        ModelFileError: a number is not finite, or the model is of a class of your own.
    """
    model_file.save(Path(path), load_model(chosen))
    return Path(path)


def _ignore_step(_: str) -> None:
    """Ignore the name of a step of the identification."""
