"""Height errors by joint and by distributed MPC, the first table of docs/distributed_mpc.md.

    python benchmarks/joint_and_distributed.py [VEHICLES ...]

`swarmN` is flown for 15 s in the air `room` with the model `measured_law`, without ROS, with seeds from 0. A
number is of all vehicles of a flight, the median over its seeds.
"""

import sys
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.values import Array
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.loop.closed_loop import LoopSettings, fly_blocks
from q2q_sim.loop.distributed import DistributedMpc, ExchangeParams
from q2q_sim.loop.flight_blocks import BlockChoices, Mode, blocks_of
from q2q_sim.monitors.metrics.exposure import exposure
from q2q_sim.scenarios import library

AIR, MODEL = "room", "measured_law"
SECONDS = 15.0
SEEDS = {2: 3, 5: 3, 10: 1}
"""Seeds of a swarm of so many vehicles."""
LATE = 10
"""Ticks by which late predictions arrive later."""


@dataclass(frozen=True, slots=True)
class Case:
    """Controller of a flight."""

    name: str
    exchange: ExchangeParams | None = None
    """None for one MPC of all vehicles."""
    mode: Mode = "aware"


CASES = (
    Case("ignoring", mode="ignoring"),
    Case("joint"),
    Case("distributed", ExchangeParams()),
    Case("distributed, 0.1 s late, 20 % lost", ExchangeParams(delay=LATE, loss=0.2)),
    Case("distributed, all lost", ExchangeParams(loss=1.0)),
)


def flown(vehicles: int, case: Case, seed: int) -> Flight:
    """Return a flight."""
    scenario = replace(library.load(f"swarm{vehicles}"), duration=SECONDS, air=AIR)
    model, choice = find_model(MODEL).interaction, BlockChoices(case.mode, "mpc")
    blocks = blocks_of(scenario, choice, model)
    if case.exchange is not None:
        exchange = replace(case.exchange, seed=seed)
        alone = DistributedMpc(scenario, choice, model, blocks.plan, exchange)
        blocks = replace(blocks, controller=alone)
    return fly_blocks(scenario, blocks, LoopSettings(case.mode, seed, find_air(AIR)))


def errors(flight: Flight) -> Array:
    """Return rms height errors under another and in clear air, and the largest under another [mm], (3,)."""
    error = 1e3 * (flight.true_pos - flight.ref_pos)[..., 2]
    under, clear = exposure(flight.true_pos, flight.t)
    rms = [np.sqrt((error[rows] ** 2).mean()) for rows in (under, clear)]
    return np.array([*rms, np.abs(error[under]).max()])


def main(sizes: list[int]) -> None:
    """Print the rows of swarms of so many vehicles."""
    for vehicles in sizes:
        for case in CASES:
            each = [errors(flown(vehicles, case, seed)) for seed in range(SEEDS[vehicles])]
            numbers = " | ".join(f"{value:.1f}" for value in np.median(each, axis=0))
            print(f"| {vehicles} | {case.name} | {SEEDS[vehicles]} | {numbers} |", flush=True)


if __name__ == "__main__":
    main([int(size) for size in sys.argv[1:]] or list(SEEDS))
