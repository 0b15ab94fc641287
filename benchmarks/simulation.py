"""Time the bare simulator: drone-steps a second for 1 to 1000 vehicles, compiled beside plain numpy.

A drone-step is one vehicle moved by one 2 ms physics step: attitude loop, rotors, rigid body and the downwash
of all its neighbours. Vehicles start as `swarmN` does (two rings, half a metre above each other, 0.6 m apart)
and tilt in turn, so that downwash is near. Both simulators take the same steps, by turns in the same run, and
each counts its fastest round in processor time, so that other programs disturb little. Beside them, how much
faster than real time one core flies the swarm.
"""

from time import process_time

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.air.find_air import FlownAir, find_air
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.plant.swarm import PHYSICS_RATE, Swarm, still_air
from q2q_sim.plant.swarm_numpy import run_numpy
from q2q_sim.scenarios import library
from row import Row

STEPS = 5
"""Physics steps a call: one tick."""
SIZES = (1, 2, 10, 100, 1000)
ROUNDS = 7
COMPILED_STEPS = 100_000
"""Drone-steps a round of the compiled simulator, about 50 ms; numpy takes far fewer."""
NUMPY_CALLS = {1: 20, 2: 20, 10: 20, 100: 5, 1000: 1}
"""Calls a round of the numpy twin."""


def run() -> list[Row]:
    """Return drone-steps a second of each size in the paper's and the measured wake."""
    rows = []
    for wake in (WakeLaw.PAPER, WakeLaw.MEASURED):
        for count in SIZES:
            compiled, plain = _rates(count, wake)
            name = f"{count} {'vehicle' if count == 1 else 'vehicles'}, {wake.name.lower()} wake"
            rows.append(Row(name, compiled, "drone-steps/s", "numpy twin", compiled / plain))
            rows.append(Row(f"{name}, numpy twin", plain, "drone-steps/s"))
            real_time = PHYSICS_RATE * count
            rows.append(Row(f"{name}, flown", compiled / real_time, "s/s", "real time", compiled / real_time))
    return [*rows, *_room_rows()]


def _room_rows() -> list[Row]:
    """Return drone-steps a second in the shipped air of a room, beside the measured wake."""
    rows, room = [], find_air("room")
    for count in SIZES:
        flights = [_flight(count, air) for air in (room, WakeLaw.MEASURED)]
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


def _rates(count: int, wake: WakeLaw) -> tuple[float, float]:
    """Return drone-steps a second of the compiled and the plain simulator."""
    swarm, commands, drive = _flight(count, wake)
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


def _flight(count: int, air: FlownAir) -> tuple[Swarm, Array, Array]:
    scenario = library.load(f"swarm{count}")
    start = np.array([vehicle.points[0] for vehicle in scenario.waypoints])
    swarm = Swarm(scenario.names, scenario.vehicle, start, air)
    commands = np.zeros((STEPS, count, 4))
    commands[..., 0] = scenario.vehicle.hover_thrust
    commands[..., 1] = 0.02 * (-1.0) ** np.arange(count)  # [rad], so that none stands still
    drive = np.hstack([np.zeros((count, 3)), np.ones((count, 4))])
    return swarm, commands, drive
