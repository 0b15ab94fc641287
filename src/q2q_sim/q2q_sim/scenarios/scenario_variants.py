"""A scenario with another firmware, air, vehicle or wake, as command lines ask for."""

from dataclasses import fields, replace

from q2q_model.vehicle.constants import firmware_of, on_firmware, vehicle_by_name
from q2q_model.vehicle.thrust_map import MOTOR_THRUST, STOCK
from q2q_sim.scenarios.scenario import Scenario


def with_firmware(scenario: Scenario, firmware: str) -> Scenario:
    """Return the scenario with another firmware; an empty name keeps the present one.

    Raises:
        ValueError: the vehicle does not have this firmware.
    """
    if not firmware:
        return scenario
    return replace(scenario, vehicle=on_firmware(scenario.vehicle, firmware))


def check_wake_or_air(wake: str, air: str) -> None:
    """Raise ValueError where both are chosen: an air is flown in place of the wake."""
    if wake and air:
        raise ValueError(f"wake = {wake!r} and air = {air!r}: give one of them; an air replaces the wake")


def with_air(scenario: Scenario, air: str, off: tuple[str, ...]) -> Scenario:
    """Return the scenario in another air, and with terms of its air switched off; empty keeps its own.

    In an air that is neither `none` nor the scenario's own wake, its `in_air` is flown if there is one.
    Terms that its own air is flown without are those of that air alone.

    Raises:
        ValueError: an unknown air, terms without an air, or a change as for `in_another_air`.
    """
    if not air and not off:
        return scenario
    other = air not in ("", "none", scenario.wake)
    flown = in_another_air(scenario) if other else scenario
    own = flown.air_without if air in ("", flown.air) else ()
    return replace(flown, air=air or flown.air, air_without=off or own)


def in_another_air(scenario: Scenario) -> Scenario:
    """Return what is flown where a flight names another air: its `in_air`, with what was changed since.

    Raises:
        ValueError: a field was changed that `in_air` replaces.
    """
    own, flown = scenario.as_written, scenario.in_air
    if own is None or flown is None:
        return flown or scenario
    changed = {name: getattr(scenario, name) for name in _differing(scenario, own)}
    replaced = _differing(flown, own)
    refused = [name for name in _differing(flown, scenario) if name in changed and name in replaced]
    if refused:
        raise ValueError(
            f"scenario {scenario.name}: {', '.join(refused)} changed, but `in_air` replaces them in another "
            "air: name the air first, then change the scenario"
        )
    return replace(flown, **changed)


def with_choices(scenario: Scenario, vehicle: str, wake: str) -> Scenario:
    """Return the scenario with another vehicle and another wake; empty names keep its own.

    The vehicle is on the scenario's firmware if it has that, else on the stock one. A wake replaces the
    scenario's air too.

    Raises:
        ValueError: an unknown vehicle or wake.
    """
    firmware = firmware_of(scenario.vehicle)
    if firmware not in MOTOR_THRUST.get(vehicle, ()):
        firmware = STOCK
    chosen = vehicle_by_name(vehicle, firmware) if vehicle else scenario.vehicle
    own, in_air = (one and with_choices(one, vehicle, wake) for one in (scenario.as_written, scenario.in_air))
    made = replace(scenario, vehicle=chosen, as_written=own, in_air=in_air)
    return replace(made, wake=wake, air="", air_without=()) if wake else made


def _differing(one: Scenario, other: Scenario) -> list[str]:
    """Return the names of the fields in which two scenarios differ, except their `in_air`."""
    names = (field.name for field in fields(Scenario) if field.compare and field.name != "in_air")
    return [name for name in names if getattr(one, name) != getattr(other, name)]
