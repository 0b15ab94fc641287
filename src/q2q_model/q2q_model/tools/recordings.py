"""Read recorded flights for the tools: bags with all they hold, and a way to say what was mended."""

import warnings
from collections.abc import Sequence
from pathlib import Path

from q2q_model.bag import BagError, BagRepairWarning, read_flight, read_flight_log
from q2q_model.bag.log_topic import LOG_TYPE
from q2q_model.flight_log import FlightLog
from q2q_model.identification.filtered_states import with_states
from q2q_model.identification.procedure import Recording


def read_recordings(bags: Sequence[Path]) -> tuple[list[Recording], list[str]]:
    """Return the flights in bags, and the repairs that reading them took.

    Raises:
        BagError: a bag cannot be read.
    """
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", BagRepairWarning)
        recordings = [Recording(with_states(read_flight(bag)), _log(bag)) for bag in bags]
    return recordings, [str(one.message) for one in said if issubclass(one.category, BagRepairWarning)]


def _log(bag: Path) -> FlightLog | None:
    """Return a bag's log of further columns; None where it has none, which its metadata tells at once."""
    metadata = bag / "metadata.yaml"
    if metadata.is_file() and LOG_TYPE not in metadata.read_text(encoding="utf-8", errors="replace"):
        return None
    try:
        return read_flight_log(bag)
    except BagError:
        return None
