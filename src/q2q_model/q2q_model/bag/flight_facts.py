"""Metadata of a flight: the vehicle and the software that flew it.

The facts are the entries of `custom_data` in metadata.yaml, as
`ros2 bag record --custom-data vehicle=crazyflie_2_1` writes them.
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from q2q_model.documents.yaml_text import load_yaml
from q2q_model.vehicle.constants import vehicle_by_name
from q2q_model.vehicle.thrust_map import STOCK

METADATA = "metadata.yaml"


@dataclass(frozen=True, slots=True)
class FlightFacts:
    """Facts about a recorded flight; empty where unknown."""

    vehicle: str = ""
    """Name in q2q_model.vehicle.constants."""
    firmware: str = ""
    """Name in q2q_model.vehicle.thrust_map."""
    scenario: str = ""
    """Scenario name or file."""
    mode: str = ""
    """ignoring, aware or aware_unlimited."""
    controller: str = ""
    correct: str = ""
    """true where positions and accelerometers corrected the predicted downwash."""
    model: str = ""
    """Interaction model of the controller."""
    wake: str = ""
    """Downwash law of the simulator."""
    air: str = ""
    """Air of the simulator in place of that law."""
    seed: str = ""
    duration: str = ""
    """Length that was to be flown [s]."""
    faults: str = ""
    """Faults that the simulator injected, as a list in JSON; [] for none."""

    @property
    def flown_air(self) -> str:
        """Return the simulator's air, else its downwash law; empty where both are unknown."""
        return self.air or self.wake

    @property
    def known(self) -> dict[str, str]:
        """Return the facts that are known."""
        return {name: value for name, value in asdict(self).items() if value}


NAMES = tuple(entry.name for entry in fields(FlightFacts))


def facts_from_text(words: Iterable[str]) -> FlightFacts:
    """Return the facts in words such as `vehicle=crazyflie_2_1`.

    Raises:
        ValueError: a word of another form, an unknown fact or vehicle, or a fact given twice.
    """
    found: dict[str, str] = {}
    for word in words:
        name, equals, value = word.partition("=")
        if not equals or name not in NAMES:
            raise ValueError(f"fact {word!r}: write name=value; name must be one of {', '.join(NAMES)}")
        if name in found:
            raise ValueError(f"fact {name} is given twice: {found[name]} and {value}")
        found[name] = value
    facts = FlightFacts(**found)
    if facts.vehicle:
        vehicle_by_name(facts.vehicle, facts.firmware or STOCK)
    return facts


def facts_as_text(facts: FlightFacts) -> tuple[str, ...]:
    """Return the known facts as words; the inverse of `facts_from_text`."""
    return tuple(f"{name}={value}" for name, value in facts.known.items())


def read_facts(path: Path | str) -> FlightFacts:
    """Return the facts in a bag's metadata; none for a ROS 1 bag or a bag without valid metadata.

    Other entries are ignored.
    """
    metadata = Path(path) / METADATA if Path(path).is_dir() else Path(path).parent / METADATA
    try:
        loaded = load_yaml(metadata)
    except ValueError:
        return FlightFacts()
    information = loaded.get("rosbag2_bagfile_information") if isinstance(loaded, dict) else None
    if not isinstance(information, dict) or not _describes(information, Path(path)):
        return FlightFacts()
    custom = information.get("custom_data")
    entries = custom.items() if isinstance(custom, dict) else ()
    return FlightFacts(**{name: str(value) for name, value in entries if name in NAMES})


def _describes(information: dict[str, object], path: Path) -> bool:
    """Return whether the metadata describes a path: its folder, or one of its files."""
    files = information.get("relative_file_paths")
    return path.is_dir() or (isinstance(files, list) and path.name in files)
