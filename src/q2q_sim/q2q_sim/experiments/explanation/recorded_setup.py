"""Recorded flight as a FlightSetup, by the metadata of its bag, checked by flying it again.

A bag names scenario, vehicle, air, controller, model and seed, but neither the replanner nor a plan around
the downwash: every replanner is tried until the positions are those of the bag.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from q2q_model.bag import FlightFacts, read_facts, read_flight
from q2q_model.flights.flight import Flight
from q2q_model.model_files.model_names import check_model_name
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array
from q2q_sim.air.air_names import check_air
from q2q_sim.experiments.explanation.flight_setup import FlightSetup, flight_setup, fly_setup
from q2q_sim.flight_bag.scenario_facts import flown_scenario
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.scenarios.choices import REPLANNERS
from q2q_sim.scenarios.scenario import Scenario

NEEDED = ("scenario", "mode", "controller", "model", "seed")
"""Metadata without which a flight cannot be flown again."""
SAME = 1e-3
"""Distance within which two flights are the same [m]: a chaotic difference soon exceeds it."""


@dataclass(frozen=True, slots=True)
class RecordedSetup:
    """Flight of a bag that can be flown again."""

    setup: FlightSetup
    flight: Flight
    """Flown again."""
    difference: float
    """Largest distance between recorded and new positions [m]."""


def recorded_setup(bag: Path) -> RecordedSetup:
    """Return the flight of a bag, flown again.

    Raises:
        ValueError: the bag cannot be read, its metadata do not suffice, or the new flight is another one.
    """
    recorded, facts = read_flight(bag), _checked(read_facts(bag), bag)
    scenario = _as_recorded(_scenario_of(facts, bag), recorded, bag)
    found = np.inf
    for replan in REPLANNERS:
        options = BlockChoices(facts.mode, facts.controller, replan, facts.correct == "true")
        setup = flight_setup(scenario, options, int(facts.seed))
        flight = fly_setup(setup)
        found = min(found, difference := largest_difference(recorded, flight))
        if difference <= SAME:
            return RecordedSetup(setup, flight, difference)
    raise ValueError(
        f"{bag}: flown again, a vehicle is {found:.3g} m off its recorded position (maximum {SAME} m): only "
        "flights in lockstep, by one controller, without --plan avoid, whose scenario has not been changed, "
        "can be explained"
    )


def _scenario_of(facts: FlightFacts, bag: Path) -> Scenario:
    """Return the scenario of a bag's metadata; errors name the bag."""
    try:
        return flown_scenario(facts, bag)
    except ValueError as unknown:
        raise ValueError(f"{bag}: {unknown}") from unknown


def _as_recorded(scenario: Scenario, recorded: Flight, bag: Path) -> Scenario:
    """Return the scenario, as short as a recording that ends before it; ValueError if it ends after it."""
    end = float(recorded.t[-1]) + 0.5 * TICK_S  # the last tick is flown, whatever is rounded
    if end > scenario.duration + TICK_S:
        raise ValueError(
            f"{bag}: recorded until {recorded.t[-1]:.2f} s, but its metadata or scenario file now say "
            f"{scenario.duration:g} s: only flights whose scenario has not been changed can be explained"
        )
    return replace(scenario, duration=end) if TICK_S < end < scenario.duration - TICK_S else scenario


def largest_difference(recorded: Flight, flown: Flight) -> float:
    """Return the largest distance of true positions, else of frames, in recorded ticks [m]; inf if none."""
    rows = np.rint(recorded.t / TICK_S).astype(np.intp)
    known = (rows >= 0) & (rows < len(flown.t))
    if recorded.names != flown.names or not known.any():
        return float("inf")
    pairs = [(recorded.true_pos, flown.true_pos), (recorded.mocap_pos, flown.mocap_pos)]
    return next(
        (
            float(np.nanmax(away))
            for old, new in pairs
            if np.isfinite(away := _distances(old[known], new[rows[known]])).any()
        ),
        float("inf"),
    )


def _distances(old: Array, new: Array) -> Array:
    return np.asarray(np.linalg.norm(old - new, axis=-1))


def _checked(facts: FlightFacts, bag: Path) -> FlightFacts:
    missing = [name for name in NEEDED if name not in facts.known]
    if missing:
        raise ValueError(
            f"{bag}: its metadata lacks {', '.join(missing)}: only flights of the simulator (`fly --bag`, "
            "`campaign`) can be flown again; see `validate` for recordings of real vehicles"
        )
    if not facts.seed.isdecimal():
        raise ValueError(f"{bag}: seed {facts.seed!r} in its metadata; must be an integer >= 0")
    _check_duration(facts.duration, bag)
    try:
        check_model_name(facts.model)
        check_air(facts.air.partition(" without ")[0] or "none")
        BlockChoices(facts.mode, facts.controller)
    except ValueError as unknown:
        raise ValueError(f"{bag}: {unknown}; a Python object cannot be flown again from a bag") from unknown
    return facts


def _check_duration(stated: str, bag: Path) -> None:
    """Raise ValueError for a duration that is no time; a bag of older software has none."""
    try:
        known = not stated or 0.0 < float(stated) < np.inf
    except ValueError:
        known = False
    if not known:
        raise ValueError(f"{bag}: duration {stated!r} in its metadata; must be above 0 s")
