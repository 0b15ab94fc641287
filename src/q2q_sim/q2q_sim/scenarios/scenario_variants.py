"""A scenario with another firmware, air, vehicle or wake, as command lines ask for."""

from dataclasses import replace

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


def with_air(scenario: Scenario, air: str, off: tuple[str, ...]) -> Scenario:
    """Return the scenario in another air, and with terms of its air switched off; empty keeps its own.

    In an air that is neither `none` nor the scenario's own wake, its `in_air` is flown if there is one.
    Terms that its own air is flown without are those of that air alone.

    Raises:
        ValueError: an unknown air, or terms without an air.
    """
    if not air and not off:
        return scenario
    other = air not in ("", "none", scenario.wake)
    flown = scenario.in_air if other and scenario.in_air is not None else scenario
    own = flown.air_without if air in ("", flown.air) else ()
    return replace(flown, air=air or flown.air, air_without=off or own)


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
    in_air = scenario.in_air if scenario.in_air is None else with_choices(scenario.in_air, vehicle, wake)
    if not wake:
        return replace(scenario, vehicle=chosen, in_air=in_air)
    return replace(scenario, vehicle=chosen, in_air=in_air, wake=wake, air="", air_without=())
