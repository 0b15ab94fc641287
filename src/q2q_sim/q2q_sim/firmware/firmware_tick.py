"""Tick of 10 ms of a swarm under its own onboard controllers, in one compiled loop.

The physics is that of q2q_sim.plant.swarm, step for step: downwash, then each vehicle's controller (500 Hz;
the position PID in the first step of a tick, 100 Hz), rotor lag, rigid body, ground. Only the source of the
rotor commands differs: here the firmware's controller and mixer, there q2q's attitude loop.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.firmware.controllers.attitude_pid import cascade
from q2q_sim.firmware.controllers.columns import CONTROLLER
from q2q_sim.firmware.controllers.mellinger import mellinger
from q2q_sim.firmware.controllers.mixer import drive_motors
from q2q_sim.plant.quadcopter import Body, move
from q2q_sim.plant.swarm import Air, Swarm, air_push, remember

STEPS = 5
"""Steps of 2 ms a tick."""
MELLINGER = 2
"""stabilizer.controller; any other value is the cascaded PID."""

Brain = tuple[Array, Array, Array, Array, Array]
"""wanted, gains, memory, frame, drift: columns.py, one row a vehicle."""


@dataclass(frozen=True, slots=True)
class Controllers:
    """Rows of all vehicles (columns.py)."""

    wanted: Array
    """Setpoints of the first step of a tick, and of the others, (n, 2, WANTED_WIDTH)."""
    gains: Array
    memory: Array
    frame: Array
    drift: Array


def _think(row: Array, brain: Brain, i: int, k: int, forces: Array) -> None:
    """Compute the motor commands of vehicle i in step k."""
    rows, gains, memory, frame, drift = brain
    wanted = rows[i, min(k, 1)]
    if gains[i, CONTROLLER] == MELLINGER:
        mellinger(row, drift[i], wanted, gains[i], memory[i])
    else:
        cascade((row, drift[i], wanted), gains[i], memory[i], k == 0)
    drive_motors(wanted, memory[i], frame[i], forces)
    for axis in range(3):
        drift[i, axis] += drift[i, 3 + axis] * 0.002  # the estimate drifts with its own velocity error


class PlantInputs(NamedTuple):
    """Air and drive of a tick."""

    air: Air
    drive: Array
    """Acceleration by moving air [m/s^2], world, then the gain of each rotor, (n, 7)."""
    body: Body


def _fly_steps(state: Array, around: PlantInputs, brain: Brain, first: int, end: int) -> None:
    air, drive, body = around
    forces = np.empty(4)
    for k in range(first, end):
        air_push(state, air, body)
        for i in range(state.shape[0]):
            think(state[i], brain, i, k, forces)
            move(state[i], forces, drive[i], body)
        remember(state, air, body.mass * GRAVITY)


think = compiled(_think)
fly_steps = compiled(_fly_steps, nogil=True)
"""Advance by some steps of a tick: (state, PlantInputs, brain, first step, step after the last)."""


def fly_tick(swarm: Swarm, controllers: Controllers, drive: Array) -> None:
    """Advance a swarm by one tick under its own controllers.

    Args:
        swarm: the vehicles; their state changes.
        controllers: setpoints and memory; memory and drift change.
        drive: acceleration by moving air [m/s^2], world, then the gain of each rotor, (n, 7).
    """
    one = controllers
    brain = (one.wanted, one.gains, one.memory, one.frame, one.drift)
    around = PlantInputs(swarm.air, drive, swarm.body)
    done = 0
    while done < STEPS:
        end = min(done + swarm.prepare(), STEPS)
        fly_steps(swarm.state, around, brain, done, end)
        done = end
