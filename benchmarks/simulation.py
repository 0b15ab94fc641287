"""Time the bare simulator: drone-steps per second for 1 to 1000 vehicles, compiled against plain numpy.

A drone-step is one vehicle moved by one 2 ms physics step: attitude loop, rotors, rigid body and the downwash
of all its neighbours. Vehicles start as `swarmN` does (two rings, half a metre above each other, 0.6 m apart)
and tilt in turn, so that downwash is near. Both simulators take the same steps, by turns in the same run, and
each counts its fastest round in processor time, so that other programs disturb little. In addition, how much
faster than real time one core flies the swarm.

Many swarms at once fly for a second from their start: one by one as swarms and in one call on one core, in
processor time, and in one call on all cores, by the wall clock. In addition, the share of the machine's peak
arithmetic and memory traffic, measured in the same run (roofline).
"""

from collections.abc import Callable
from functools import partial
from time import perf_counter, process_time

import numpy as np

from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.plant.swarm import PHYSICS_RATE
from q2q_sim.plant.swarm_air import still_air
from q2q_sim.plant.swarm_batch import SwarmBatch, SwarmBatchSetup
from roofline import BYTES, CORES, flops_of_a_step, peak_flops, peak_traffic
from row import Row
from simulated_swarms import STEPS, scenario_of, start_of, swarm_flight, swarm_of
from swarm_numpy import run_numpy

SIZES = (1, 2, 10, 100, 1000)
ROUNDS = 7
COMPILED_STEPS = 100_000
"""Drone-steps per round of the compiled simulator, about 50 ms; numpy takes far fewer."""
NUMPY_CALLS = {1: 20, 2: 20, 10: 20, 100: 5, 1000: 1}
"""Calls a round of the numpy twin."""
BATCHES = ((500, 2), (100, 10), (10, 100), (2, 1000))
"""Swarms, and vehicles in each."""
BATCH_CALLS = 100
"""Calls a round: 1 s of flight, in which all random numbers are drawn once."""
BATCH_ROUNDS = 3


def run() -> list[Row]:
    """Return drone-steps per second of each size in the paper's and the measured wake."""
    rows = []
    for wake in (WakeLaw.PAPER, WakeLaw.MEASURED):
        for count in SIZES:
            compiled, plain = _rates(count, wake)
            name = f"{count} {'vehicle' if count == 1 else 'vehicles'}, {wake.name.lower()} wake"
            rows.append(Row(name, compiled, "drone-steps/s", "numpy twin", compiled / plain))
            rows.append(Row(f"{name}, numpy twin", plain, "drone-steps/s"))
            real_time = PHYSICS_RATE * count
            rows.append(Row(f"{name}, flown", compiled / real_time, "s/s", "real time", compiled / real_time))
    return [*rows, *_room_rows(), *_batch_rows()]


def _room_rows() -> list[Row]:
    """Return drone-steps per second in the shipped air of a room, against the measured wake."""
    rows, room = [], find_air("room")
    for count in SIZES:
        flights = [swarm_flight(count, air) for air in (room, WakeLaw.MEASURED)]
        calls = max(COMPILED_STEPS // (STEPS * count), 1)
        best = [np.inf, np.inf]
        for _ in range(ROUNDS):
            for k, (swarm, commands, drive) in enumerate(flights):
                start = process_time()
                for _ in range(calls):
                    swarm.step(commands, drive)
                best[k] = min(best[k], (process_time() - start) / calls)
        name = f"{count} {'vehicle' if count == 1 else 'vehicles'}, air of a room"
        rows.append(Row(name, STEPS * count / best[0], "drone-steps/s", "measured wake", best[1] / best[0]))
    return rows


def _batch_rows() -> list[Row]:
    """Return drone-steps per second of many swarms at once, against the same one by one, and the roofline."""
    flops, traffic = peak_flops(), peak_traffic()
    rows = [
        Row(f"machine: matrix product, {CORES} cores", flops / 1e9, "GFLOP/s"),
        Row(f"machine: copy in memory, {CORES} cores", traffic / 1e9, "GB/s"),
    ]
    for swarms, count in BATCHES:
        alone, together, all_cores = _batch_rates(swarms, count)
        name, each = f"{swarms} swarms of {count} vehicles, air of a room", flops_of_a_step(count)
        rows += [
            Row(f"{name}, one by one", alone, "drone-steps/s"),
            Row(f"{name}, 1 core", together, "drone-steps/s", "one by one", together / alone),
            Row(f"{name}, {CORES} cores", all_cores, "drone-steps/s", "one by one", all_cores / alone),
            Row(f"{name}, arithmetic of a drone-step", each, "FLOP"),
            Row(f"{name}, {CORES} cores, share of arithmetic", 100.0 * each * all_cores / flops, "%"),
            Row(f"{name}, {CORES} cores, share of traffic", 100.0 * BYTES * all_cores / traffic, "%"),
        ]
    return rows


def _batch_rates(swarms: int, count: int) -> tuple[float, float, float]:
    """Return drone-steps per second of swarms one by one, together on one core, and together on all cores."""
    room, scenario = find_air("room"), scenario_of(count)
    assert isinstance(room, RoomAir)
    _, commands, drive = swarm_flight(count, room)
    setup = SwarmBatchSetup(scenario.vehicle, np.stack([start_of(count)] * swarms), room)
    inputs = np.stack([commands] * swarms, axis=1), np.stack([drive] * swarms)
    best = [np.inf, np.inf, np.inf]
    for _ in range(BATCH_ROUNDS):
        for k, threads in enumerate((0, 1, CORES)):
            flown: list[Callable[[], None]] = (
                [partial(SwarmBatch(setup, threads).step, *inputs)]
                if threads
                else [partial(swarm_of(count, room, seed).step, commands, drive) for seed in range(swarms)]
            )
            clock = perf_counter if threads > 1 else process_time
            start = clock()
            for _ in range(BATCH_CALLS):
                for step in flown:
                    step()
            best[k] = min(best[k], clock() - start)
    done = swarms * count * STEPS * BATCH_CALLS
    return done / best[0], done / best[1], done / best[2]


def _rates(count: int, wake: WakeLaw) -> tuple[float, float]:
    """Return drone-steps per second of the compiled and the plain simulator."""
    swarm, commands, drive = swarm_flight(count, wake)
    state = swarm.state.copy()
    air = still_air(state, wake, swarm.body)
    swarm.step(commands, drive)  # compiles
    calls = max(COMPILED_STEPS // (STEPS * count), 1)
    best = [np.inf, np.inf]
    for _ in range(ROUNDS):
        start = process_time()
        for _ in range(calls):
            swarm.step(commands, drive)
        best[0] = min(best[0], (process_time() - start) / calls)
        start = process_time()
        for _ in range(NUMPY_CALLS[count]):
            run_numpy(state, air, commands, drive, swarm.body)
        best[1] = min(best[1], (process_time() - start) / NUMPY_CALLS[count])
    return STEPS * count / best[0], STEPS * count / best[1]
