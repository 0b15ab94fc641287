"""Bag that the recorder of a flight could not finish: why, and how far it can be read.

A recorder whose disk takes no more lets the vehicles fly on (q2q_sim.ros.bag_record_node). What they did
after the end of the bag is not known, so the flight is not ok.
"""

from pathlib import Path
from tempfile import gettempdir

from q2q_model.bag import BagError, BagReader, read_flight
from q2q_model.flights.flight import Flight
from q2q_sim.monitors.flight_verdict import Finding
from q2q_sim.node_flights.running_nodes import RECORDER

REMEDY = "make room or choose another disk, and fly again"
REMEDY_OF_TEMPORARY = "make room there or set another TMPDIR, and fly again"


def recorder_notes(folder: Path) -> list[str]:
    """Return what the recorder of a flight said: messages it lost, a disk that took no more."""
    return [line for line in log_lines(folder) if line.startswith(f"{RECORDER}: ")]


def log_lines(folder: Path) -> list[str]:
    """Return the lines of the logs of a flight's nodes."""
    logs = [one.read_text(encoding="utf-8", errors="replace") for one in sorted(folder.glob("*.log"))]
    return [line for log in logs for line in log.splitlines()]


def why_unfinished(bag: Path, folder: Path) -> str:
    """Return why the recorder did not finish a bag; empty for a finished one.

    Args:
        bag: the bag of a flight that is over.
        folder: the folder of its nodes' logs, which lack the reason if they lie on a full disk, too.
    """
    try:
        if not BagReader(bag).repairs:
            return ""
    except BagError:  # nothing in it can be read
        pass
    given = [note.partition(f"{bag}: ")[2].partition(";")[0] for note in recorder_notes(folder)]
    return next(filter(None, given), "its recorder did not close it")


def read_flown(bag: Path, unfinished: str, *, temporary: bool) -> Flight:
    """Return the flight in a bag; `unfinished` is the answer of why_unfinished.

    Raises:
        BagError: nothing can be read.
    """
    try:
        return read_flight(bag)
    except BagError as unreadable:
        if not unfinished:
            raise
        raise BagError(
            f"nothing of the flight can be read from its {_place(bag, temporary=temporary)} ({unfinished}): "
            f"{_remedy(temporary=temporary)}"
        ) from unreadable


def end_of_bag(bag: Path, flight: Flight, flown: float, unfinished: str, *, temporary: bool) -> Finding:
    """Return the finding that a bag ends before its flight, which took `flown` [s]."""
    end = float(flight.t[-1] - flight.t[0])
    readable = f"the {_place(bag, temporary=temporary)} can be read up to {end:.1f} s of {flown:.1f} s"
    said = f"{readable}, and nothing later is judged ({unfinished}): {_remedy(temporary=temporary)}"
    return Finding(float(flight.t[-1]), said)


def _place(bag: Path, *, temporary: bool) -> str:
    """Return where a bag is; of a temporary one, which is deleted, the folder that has no room."""
    return f"temporary bag in {gettempdir()}" if temporary else f"bag {bag}"


def _remedy(*, temporary: bool) -> str:
    return REMEDY_OF_TEMPORARY if temporary else REMEDY
