"""Vehicle of a bag: the user's choice, else the one in its metadata, else the default."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from q2q_model.bag import read_facts
from q2q_model.counted import first_of
from q2q_model.vehicle.constants import DEFAULT_VEHICLE, VEHICLE_OPTION, Vehicle, vehicle_by_name
from q2q_model.vehicle.thrust_map import STOCK


@dataclass(frozen=True, slots=True)
class FlownVehicle:
    """Vehicle of some flights."""

    vehicle: Vehicle
    note: str = ""
    """Remark if the vehicle is unknown and the default is used."""


def flown_vehicle(bag: Path, override: str = "") -> FlownVehicle:
    """Return the vehicle of a bag; `override` overrides the bag's metadata.

    Raises:
        ValueError: `override`, or the vehicle that the bag names, does not exist.
    """
    if override:
        return FlownVehicle(vehicle_by_name(override))
    facts = read_facts(bag)
    if not facts.vehicle:
        note = f"{bag} does not name its vehicle: {DEFAULT_VEHICLE} is assumed; name it with {VEHICLE_OPTION}"
        return FlownVehicle(vehicle_by_name(DEFAULT_VEHICLE), note)
    try:
        return FlownVehicle(vehicle_by_name(facts.vehicle, facts.firmware or STOCK))
    except ValueError as unknown:
        raise ValueError(f"bag {bag}: {unknown}; name the vehicle with {VEHICLE_OPTION}") from unknown


def common_vehicle(bags: Sequence[Path], override: str = "") -> FlownVehicle:
    """Return the common vehicle of several bags.

    Bags that name no vehicle are assumed to be of the same vehicle as the others.

    Raises:
        ValueError: as `flown_vehicle`, or bags of different vehicles.
    """
    found = [flown_vehicle(bag, override) for bag in bags]
    named = {one.vehicle.name: bag for one, bag in zip(found, bags, strict=True) if not one.note}
    if len(named) > 1:
        flown = ", ".join(f"{bag} of {name}" for name, bag in named.items())
        raise ValueError(
            f"bags of different vehicles, {flown}: process them separately, or name one with {VEHICLE_OPTION}"
        )
    unnamed = [str(bag) for one, bag in zip(found, bags, strict=True) if one.note]
    vehicle = next((one.vehicle for one in found if not one.note), found[0].vehicle)
    if not unnamed:
        return FlownVehicle(vehicle)
    which = " ".join(first_of(unnamed, 1))
    note = f"no vehicle is named in {which}: {vehicle.name} is assumed; name it with {VEHICLE_OPTION}"
    return FlownVehicle(vehicle, note)
