"""Program to fly, and how: trial, vehicles, limits of time."""

from dataclasses import dataclass
from pathlib import Path

from q2q_sim.licence.crazyflie_py.served_vehicles import ServedVehicle
from q2q_sim.licence.room.licence_log import escaped
from q2q_sim.licence.room.licence_room import LicenceParams
from q2q_sim.licence.room.trials import LicenceTrial

PROGRAM_TIMEOUT_S = 140.0
"""Wall time after which a flight that waits outside Python's clock is ended [s]."""


@dataclass(frozen=True, slots=True)
class Program:
    """Program with its arguments."""

    file: Path
    arguments: tuple[str, ...] = ()
    folder: Path = Path()
    """Working folder."""

    @property
    def name(self) -> str:
        """Return the name of the file, as it can be written."""
        return escaped(self.file.name)


@dataclass(frozen=True, slots=True)
class FlightOrder:
    """What is flown."""

    program: Program
    params: LicenceParams
    trial: LicenceTrial
    uris: tuple[str, ...]
    """URIs of the vehicles; empty for those that the program opens, in its order."""
    scanned: tuple[str, ...]
    """URIs that a scan answers."""
    limit: float
    """Longest flight [s]."""
    served: tuple[ServedVehicle, ...] = ()
    """Vehicles of a crazyflies.yaml, which are all; empty for stock ones at the URIs that a scan answers."""
    survey: bool = False
    """Only up to the first command that asks for flight."""
    timeout: float = PROGRAM_TIMEOUT_S
    """[s]"""
