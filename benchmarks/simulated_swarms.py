"""Swarms that the benchmarks of the simulator step: those of `swarmN`, at hover and tilted in turn."""

from functools import cache

import numpy as np

from q2q_model.signals.values import Array
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.plant.swarm import Swarm
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario

STEPS = 5
"""Physics steps per call: one tick."""
TILT = 0.02
"""Commanded roll [rad], of either sign in turn, so that none stands still."""


def swarm_flight(count: int, air: FlownAir) -> tuple[Swarm, Array, Array]:
    """Return a swarm, its commands (STEPS, count, 4) and its drive (count, 7): still air, rotors as made."""
    commands = np.zeros((STEPS, count, 4))
    commands[..., 0] = scenario_of(count).vehicle.hover_thrust
    commands[..., 1] = TILT * (-1.0) ** np.arange(count)
    drive = np.hstack([np.zeros((count, 3)), np.ones((count, 4))])
    return swarm_of(count, air), commands, drive


def swarm_of(count: int, air: FlownAir, seed: int = 0) -> Swarm:
    """Return a swarm at its start, in an air of this seed."""
    scenario = scenario_of(count)
    return Swarm(scenario.names, scenario.vehicle, start_of(count), air, seed)


def start_of(count: int) -> Array:
    """Return x, y, z [m] and yaw [rad] of every vehicle at the start, (count, 4)."""
    return np.array([vehicle.points[0] for vehicle in scenario_of(count).waypoints])


@cache
def scenario_of(count: int) -> Scenario:
    """Return the shipped scenario of `count` vehicles."""
    return library.load(f"swarm{count}")
