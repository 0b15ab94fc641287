"""Flight of a controller under a perturbation, with the height errors of the vehicles under another.

| symbol | name | meaning [unit] |
|---|---|---|
| | under | rms of all draws (q2q_sim.monitors.metrics.exposure) [m] |
| | worst | median of the draws' largest error [m] |
| | left | rms of the last LEFT seconds, all vehicles: wind-up or limit cycles would show [m] |
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.downwash.jet import Jet
from q2q_model.flights.flight import Flight
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.stamps import TICK_S
from q2q_model.vehicle.thrust_map import STOCK
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.experiments.ablation.side_by_side import side_by_side
from q2q_sim.experiments.robustness.perturbations import (
    Perturbation,
    assumed_model,
    flown_room,
    with_faster_paths,
)
from q2q_sim.loop.closed_loop import LoopSettings, fly_blocks
from q2q_sim.loop.flight_blocks import BlockChoices, Mode, blocks_of, ignore_accelerometers
from q2q_sim.monitors.metrics.exposure import exposure
from q2q_sim.monitors.metrics.flight_metrics import largest, rms
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_variants import with_air, with_firmware

DURATION = 19.0
"""Length of a flight [s]: the last passage has ended 4 s before or more."""
LEFT = 2.0
"""[s]"""
PAPER = "paper"


class Errors(NamedTuple):
    """Height errors of a flight [m]."""

    under: float
    worst: float
    left: float


@dataclass(frozen=True, slots=True)
class PerturbedFlight:
    """One flight: draws side by side."""

    air: str
    perturbation: Perturbation
    controller: str
    corrects: bool
    """Aware and corrected; else it ignores the downwash."""
    draws: int
    seed: int


def fly_perturbed(asked: PerturbedFlight) -> Errors:
    """Return the errors of a flight."""
    loaded = with_air(library.load(asked.perturbation.scenario), asked.air, ())
    one = replace(with_faster_paths(with_firmware(loaded, STOCK)), duration=DURATION)
    scenario = side_by_side([one], asked.draws)
    model = model_in(scenario, asked.air)
    mode: Mode = "aware" if asked.corrects else "ignoring"
    choice = BlockChoices(mode, asked.controller, correct=asked.corrects)
    blocks = blocks_of(scenario, choice, assumed_model(model, asked.perturbation), residual=REAL_FLIGHTS)
    if asked.perturbation.silent:
        blocks = replace(blocks, sense=ignore_accelerometers)
    settings = LoopSettings(mode, asked.seed, find_air(asked.air))
    flight = fly_blocks(flown_room(scenario, asked.perturbation), blocks, settings)
    return draw_errors(flight, len(one.names))


def model_in(scenario: Scenario, air: str) -> Jet:
    """Return the model of the scenario, in the paper's air the paper's law.

    Raises:
        ValueError: the scenario's model is no jet.
    """
    name = "paper_law" if air == PAPER else scenario.model
    found = find_model(name).interaction
    if isinstance(found, Jet):
        return found
    raise ValueError(f"model {name} is not a jet: its strength and delay cannot be changed")


def draw_errors(flight: Flight, each: int) -> Errors:
    """Return the errors of a flight of draws of `each` vehicles; NaN where none was under another."""
    error = flight.true_pos[..., 2] - flight.ref_pos[..., 2]
    found = []
    for start in range(0, error.shape[1], each):
        own = slice(start, start + each)
        found.append(error[:, own][exposure(flight.true_pos[:, own], flight.t).under])
    return Errors(
        under=rms(np.concatenate(found)),
        worst=float(np.median([largest(draw) for draw in found])),
        left=rms(error[-round(LEFT / TICK_S) :]),
    )
