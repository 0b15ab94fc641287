"""Names of air models, checked without the imports that these need."""

import os
from collections.abc import Sequence
from pathlib import Path

from q2q_model.documents.shipped_folder import shipped_folder, shipped_or_given
from q2q_model.own_class import is_own_class

SUFFIX = ".air"
LAWS = ("none", "paper", "measured")
"""Wake laws (q2q_sim.air.wake_laws)."""
SYNTHETIC = ("ring", "heavy_tailed", "bent", "meandering")
"""Air of other families than the models (q2q_sim.air.synthetic_airs)."""
ROOM = "room"
"""Shipped air of a room, learned from real flights."""
RECORDED = "recorded"
"""That room with the residuals of its flights played back (q2q_sim.air.learning.recorded_air); those of other
flights are named `recorded:PATH`."""
FLIGHTS = Path("neural_swarm")
"""Folder of the room's flights within Q2Q_DATA."""


class AirError(ValueError):
    """Error for an air that does not exist, is not valid, or gives no valid push."""


def check_air(name: str) -> None:
    """Raise AirError if there is neither an air nor a file of this name; `module:Class` is not imported."""
    if is_recorded(name):
        recorded_paths(name)
    elif name not in (*LAWS, *SYNTHETIC) and not is_own_class(name):
        air_path(name)


def is_recorded(name: str) -> bool:
    """Return whether an air plays back recorded residuals."""
    return name.partition(":")[0] == RECORDED


def recorded_paths(name: str, flights: Sequence[str] = ()) -> list[Path]:
    """Return where the flights of a recorded air are: a given path, else tables of `flights` in Q2Q_DATA.

    Raises:
        AirError: they do not exist.
    """
    given = name.partition(":")[2]
    if given:
        if not Path(given).exists():
            raise AirError(f"air {name}: no such file {given}: give a bag, a table or a folder of them")
        return [Path(given)]
    folder = flights_folder()
    paths = [folder / f"{flight}.parquet" for flight in flights]
    lacking = [path.stem for path in paths if not path.is_file()]
    if not folder.is_dir() or lacking:
        raise AirError(
            f"air {name}: no {', '.join(lacking) or 'recorded flights'} in {folder}: get the flights of "
            f"docs/real_flights.md and set Q2Q_DATA to the folder of {FLIGHTS}/, or give your own: "
            f"{RECORDED}:PATH"
        )
    return paths


def flights_folder() -> Path:
    """Return the folder of recorded real flights in Q2Q_DATA; it may not exist."""
    return Path(os.environ.get("Q2Q_DATA", "../shared/data")) / FLIGHTS


def flight_path(name: str) -> Path:
    """Return the file of a real flight.

    Raises:
        ValueError: Q2Q_DATA is not a folder of flights, or has no flight of this name.
    """
    folder = flights_folder()
    known = sorted(path.stem for path in folder.glob("*.parquet"))
    if not known:
        raise ValueError(f"no recorded flights in {folder}: set Q2Q_DATA to the folder that holds {FLIGHTS}/")
    if name not in known:
        raise ValueError(f"no flight {name!r} in {folder}; there are {', '.join(known)}")
    return folder / f"{name}.parquet"


def air_path(name: str) -> Path:
    """Return the file of an air, given by the name of a shipped one or by its path.

    Raises:
        AirError: the air does not exist.
    """
    shipped = shipped_airs()
    if (found := shipped_or_given(name, shipped / f"{name}{SUFFIX}")) is not None:
        return found
    learned = sorted(path.stem for path in shipped.glob(f"*{SUFFIX}"))
    known = ", ".join((*LAWS, *SYNTHETIC, RECORDED, *learned))
    raise AirError(f"no air {name!r}: give one of {known}, a {SUFFIX} file, or module:Class")


def shipped_airs() -> Path:
    """Return the folder of the shipped `.air` files."""
    return shipped_folder(Path(__file__).resolve().parents[1])
