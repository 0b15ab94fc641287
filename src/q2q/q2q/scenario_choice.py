"""Scenarios by name, from a file or from a document."""

import reprlib
from collections.abc import Mapping
from pathlib import Path

from q2q_sim.air.lookup.find_air import FlownAir, find_air
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_document import scenario_from_document
from q2q_sim.scenarios.scenario_variants import check_wake_or_air, with_air, with_choices

ScenarioChoice = str | Path | Mapping[str, object] | Scenario
"""Scenario, its name or file, or its document (the keys of a scenario file)."""


AirName = str | Path
"""Shipped name of an air, as "room", path of a .air file, or "module:Class"."""


def scenario(chosen: ScenarioChoice, *, vehicle: str = "", wake: str = "", air: AirName = "") -> Scenario:
    """Return a scenario, a frozen dataclass: change its fields by `dataclasses.replace`.

    Args:
        chosen: name (`scenario_names`; `swarmN` for N vehicles), path of a scenario or waypoint file (.yaml)
            or of a plan (.json), document with the keys of a scenario file
            (q2q_sim.scenarios.scenario_document), or a scenario.
        vehicle: name of the vehicle, as "crazyflie_2_1"; empty keeps the scenario's own.
        wake: law of the true downwash, "none", "paper" or "measured"; empty keeps the scenario's own.
        air: air in place of wake and disturbance: a shipped name, as "room", a .air file or "module:Class".

    Raises:
        ValueError: a name, key or value that is not allowed, or a wake and an air; the message says what is.
        TypeError: `chosen` is no scenario, or `air` no name; an air object is given to `q2q.fly`.
    """
    check_wake_or_air(wake, air_name(air))
    return with_air(with_choices(_found(chosen), vehicle, wake), air_name(air), ())


def scenario_names() -> list[str]:
    """Return the names of the shipped scenarios; `swarm10` represents any `swarmN`."""
    return library.names()


def load_air(name: AirName, *, without: tuple[str, ...] = ()) -> FlownAir:
    """Return an air: a `q2q.RoomAir` (a learned or synthetic one), a law, or a class of your own.

    A RoomAir is a frozen dataclass: change its terms by `dataclasses.replace`, after
    `assert isinstance(air, q2q.RoomAir)` for type checkers.

    Args:
        name: a shipped name, as "room", a .air file or "module:Class".
        without: terms that are switched off, as ("residual",).

    Raises:
        AirError: there is no such air or term.
        TypeError: `name` is no name, or `without` no tuple of names.
    """
    if isinstance(without, str):
        raise TypeError(f"without = {without!r}; must be a tuple of terms, like ({without!r},)")
    return find_air(air_name(name), without)


def air_name(given: AirName) -> str:
    """Return the name of an air as text; raise TypeError for what is none."""
    if not isinstance(given, str | Path):
        shown = reprlib.repr(given)
        raise TypeError(f"air = {shown}; must be a shipped name, the path of a .air file or module:Class")
    return str(given)


def _found(chosen: ScenarioChoice) -> Scenario:
    if isinstance(chosen, Scenario):
        return chosen
    if isinstance(chosen, Mapping):
        return scenario_from_document("document", chosen)
    if not isinstance(chosen, str | Path):
        raise TypeError(f"scenario = {chosen!r}; must be a name, a file, a document or a q2q.Scenario")
    return library.load(str(chosen))
