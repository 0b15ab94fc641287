"""Tick of 10 ms of a swarm under its own onboard controllers, in one compiled loop.

The physics is that of q2q_sim.plant.swarm, step for step: downwash, then each vehicle's controller (500 Hz;
the position PID in the first step of a tick, 100 Hz), rotor lag, rigid body, ground. Only the source of the
rotor commands differs: here the firmware's controller and mixer, there q2q's attitude loop.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from q2q_model.compiled import compiled
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, Vehicle
from q2q_sim.firmware.controllers.attitude_pid import DT, cascade
from q2q_sim.firmware.controllers.choice import FirmwareController
from q2q_sim.firmware.controllers.columns import CONTROLLER, SETPOINT_WIDTH, frame_row, fresh_memory
from q2q_sim.firmware.controllers.mellinger import mellinger
from q2q_sim.firmware.controllers.mixer import drive_motors
from q2q_sim.firmware.motors.airframe import Airframe, airframe_of
from q2q_sim.plant.body.quadcopter import Body, move
from q2q_sim.plant.push.state_history_ring import remember
from q2q_sim.plant.swarm import Swarm
from q2q_sim.plant.swarm_air import Air, air_push

STEPS = 5
"""Steps of 2 ms a tick."""
MELLINGER = float(FirmwareController.MELLINGER)
"""stabilizer.controller; any other value is the cascaded PID."""


class Controllers(NamedTuple):
    """Rows of all vehicles (columns.py)."""

    setpoints: Array
    """Setpoints of the first step of a tick, and of the others, (n, 2, SETPOINT_WIDTH)."""
    gains: Array
    """(n, GAIN_WIDTH)"""
    memory: Array
    """(n, MEMORY_WIDTH)"""
    frame: Array
    """(n, FRAME_WIDTH)"""
    drift: Array
    """[m], [m/s], world, (n, 6)."""


def airframe_in(swarm: Swarm, vehicle: Vehicle) -> Airframe:
    """Return the airframe of a swarm's vehicles, whose rotors give what the swarm's air leaves them."""
    _, _, rotor_max = swarm.body.frame
    return replace(airframe_of(vehicle), rotor_max=rotor_max)


def fresh_controllers(airframe: Airframe, vehicles: int) -> Controllers:
    """Return controllers that have not run yet, without gains and setpoints."""
    return Controllers(
        setpoints=np.zeros((vehicles, 2, SETPOINT_WIDTH)),
        gains=np.zeros((vehicles, 0)),
        memory=fresh_memory(vehicles),
        frame=np.tile(frame_row(airframe), (vehicles, 1)),
        drift=np.zeros((vehicles, 6)),
    )


@compiled
def control_motors(row: Array, controllers: Controllers, i: int, k: int, forces: Array) -> None:
    """Write the rotor forces (4,) [N] that vehicle i, of state `row`, commands in step k of a tick.

    Its memory and drift advance.
    """
    _, gains, memory, frame, drift = controllers
    setpoint = controllers.setpoints[i, min(k, 1)]
    if gains[i, CONTROLLER] == MELLINGER:
        mellinger(row, drift[i], setpoint, gains[i], memory[i])
    else:
        cascade((row, drift[i], setpoint), gains[i], memory[i], k == 0)
    drive_motors(setpoint, memory[i], frame[i], forces)
    for axis in range(3):
        drift[i, axis] += drift[i, 3 + axis] * DT  # the estimate drifts with its own velocity error


class PlantInputs(NamedTuple):
    """Air and drive of a tick."""

    air: Air
    drive: Array
    """Acceleration by wind [m/s^2], world, then the gain of each rotor, (n, 7)."""
    body: Body


@compiled(nogil=True)
def fly_steps(state: Array, around: PlantInputs, controllers: Controllers, first: int, end: int) -> None:
    """Advance `state` (n, STATE_WIDTH) from step `first` of a tick to the step before `end`."""
    air, drive, body = around
    forces = np.empty(4)
    for k in range(first, end):
        air_push(state, air, body)
        for i in range(state.shape[0]):
            control_motors(state[i], controllers, i, k, forces)
            move(state[i], forces, drive[i], body)
        remember(state, air.ring, air.rows, body.mass * GRAVITY)


def fly_tick(
    swarm: Swarm, controllers: Controllers, drive: Array, each: Callable[[], None] | None = None
) -> None:
    """Advance a swarm by one tick under its own controllers.

    Args:
        swarm: the vehicles; their state changes.
        controllers: setpoints and memory; memory and drift change.
        drive: acceleration by wind [m/s^2], world, then the gain of each rotor, (n, 7).
        each: called before every step, if given.
    """
    around = PlantInputs(swarm.air, drive, swarm.body)
    done = 0
    while done < STEPS:
        end = min(done + swarm.prepare(), STEPS if each is None else done + 1)
        if each is not None:
            each()
        fly_steps(swarm.state, around, controllers, done, end)
        done = end
