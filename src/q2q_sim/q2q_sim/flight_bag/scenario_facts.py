"""Metadata of a scenario's flight, for its bag, and the scenario and faults that a bag's metadata give.

A bag has the faults themselves, since the scenario's file may be changed after the flight.
"""

import json
import warnings
from dataclasses import replace
from pathlib import Path

from q2q_model.bag import FlightFacts, read_facts
from q2q_model.documents.plain_values import from_plain, to_plain
from q2q_model.documents.yaml_text import parse_yaml
from q2q_model.vehicle.constants import firmware_of, is_named
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.loop.scenario_air import air_description
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_variants import with_air, with_choices, with_firmware


def scenario_facts(scenario: Scenario, options: BlockChoices, seed: int, name: str = "") -> FlightFacts:
    """Return the metadata of a flight; `name` is that of the scenario or its file, if not its own."""
    return FlightFacts(
        vehicle=scenario.vehicle.name if is_named(scenario.vehicle) else "",
        firmware=firmware_of(scenario.vehicle),
        scenario=name or scenario.name,
        mode=options.mode,
        controller=options.controller,
        correct="true" if options.correct else "",
        model=scenario.model,
        wake="" if scenario.air else scenario.wake,
        air=air_description(scenario),
        seed=str(seed),
        duration=repr(scenario.duration).removesuffix(".0"),
        faults=json.dumps(to_plain(scenario.faults, "faults")),
    )


def flown_scenario(facts: FlightFacts, bag: Path) -> Scenario:
    """Return the scenario of a bag's metadata: a name, or a file in the bag, at its path or next to it.

    It is as long as the flight was to last, where the metadata say so.
    """
    own = library.load(str(_scenario_file(facts, bag) or facts.scenario))
    if facts.wake and (own.air or own.wake != facts.wake):
        own = with_choices(own, "", facts.wake)
    if facts.air and facts.air != air_description(own):
        air, *off = facts.air.split(" without ")
        own = with_air(own, air, tuple(off))
    if facts.vehicle and own.vehicle.name != facts.vehicle:
        own = with_choices(own, facts.vehicle, "")
    length = float(facts.duration) if facts.duration else own.duration
    return replace(with_firmware(own, facts.firmware), model=facts.model, duration=length)


def flown_faults(bag: Path) -> tuple[Fault, ...]:
    """Return the faults that were injected in a bag's flight; none, with a warning, if they cannot be read.

    A bag of older software has those of its scenario, with a warning if a file outside the bag gives it: it
    may have been changed since. A bag that names no scenario has none.
    """
    facts = read_facts(bag)
    try:
        if facts.faults:
            return from_plain(tuple[Fault, ...], parse_yaml(facts.faults), "faults")
        return _faults_of_scenario(facts, bag) if facts.scenario else ()
    except ValueError as error:
        warnings.warn(f"bag {bag}: its faults are unknown: {error}", stacklevel=2)
        return ()


def _faults_of_scenario(facts: FlightFacts, bag: Path) -> tuple[Fault, ...]:
    faults, file = flown_scenario(facts, bag).faults, _scenario_file(facts, bag)
    if file is not None and file.parent != (bag if bag.is_dir() else bag.parent):
        words = f"the bag does not record its faults: those that {file} has now are assumed"
        warnings.warn(f"bag {bag}: {words}", stacklevel=3)
    return faults


def _scenario_file(facts: FlightFacts, bag: Path) -> Path | None:
    """Return the file of a bag's scenario; None if it is none that is found."""
    files = (folder / facts.scenario for folder in (bag, Path(), bag.parent))
    return next((file for file in files if file.is_file()), None)
