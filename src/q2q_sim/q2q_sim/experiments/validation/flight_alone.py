"""A vehicle alone, flown again along its recorded position setpoints by the emulated firmware.

A flight of one vehicle whose log has setpoints but no thrust commands does not determine its control law. The
simulated vehicle flies by the stock position PID of the firmware (q2q_sim.firmware), from the recorded first
state, in the air with its offset and gusts, and knows its state exactly. Compared are the errors r - r_ref of
position in flight: the height under the names of `error_statistics`, x and y together as `lateral`. The
recorded errors are those of the motion capture, so they contain the errors of the vehicle's own estimate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.flights.interpolated_gaps import resample
from q2q_model.flights.sampled_reference import setpoint_positions
from q2q_model.geometry.rotations import normalised, yaw_from_quat
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.experiments.validation.error_spectrum import CLEAR_SHARE
from q2q_sim.experiments.validation.error_statistics import ErrorSums, error_sums
from q2q_sim.experiments.validation.recorded.tracked_flight import flying_grid
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.controllers.columns import Power, setpoint_row
from q2q_sim.firmware.firmware_tick import airframe_in, fly_tick, fresh_controllers
from q2q_sim.firmware.parameters.parameter_values import Parameters
from q2q_sim.loop.scenario_air import ambient_of_air
from q2q_sim.plant.body.state_row import POS, QUAT, VEL
from q2q_sim.plant.swarm import Swarm

LOST = 2.0
"""Distance from the setpoint at which a recorded vehicle is lost [m]: a position setpoint without velocity
leads by up to 1.2 m on the fastest paths."""
TICK = 0.01
"""Period of the firmware's position loop [s]."""


@dataclass(frozen=True, slots=True)
class FlightAlone:
    """Recorded flight of one vehicle along position setpoints."""

    name: str
    pos: Array
    """[m], world, (T, 3)."""
    ref_pos: Array
    """[m], world, (T, 3)."""
    vel: Array
    """First velocity [m/s], world, (3,)."""
    quat: Array
    """First attitude, (4,)."""


@dataclass(frozen=True, slots=True)
class ComparedAlone:
    """Errors of a flight and its draws."""

    name: str
    vertical: ErrorSums
    lateral: ErrorSums


def is_alone(recording: Recording) -> bool:
    """Return whether a recording is of one vehicle that has setpoints, but no thrust commands."""
    flight = recording.flight
    known = np.isfinite(setpoint_positions(flight)).any() and not np.isfinite(flight.thrust).any()
    return len(flight.names) == 1 and bool(known)


def flight_alone(recording: Recording) -> FlightAlone:
    """Return the flight of a recording, every 10 ms.

    Raises:
        ValueError: it is never in the air for 5 s, or loses its setpoint.
    """
    flight = recording.flight
    between = flying_grid(flight)
    grid = np.arange(between[0], between[-1], TICK)
    pos, ref = (resample(flight.t, values[:, 0], grid) for values in (flight.pos, setpoint_positions(flight)))
    away = float(np.linalg.norm(pos - ref, axis=1).max())
    if away > LOST:
        raise ValueError(
            f"flight {flight.name} cannot be flown again: its vehicle is up to {away:.1f} m from its "
            f"setpoint (maximum {LOST:.0f} m)"
        )
    vel = np.gradient(pos[:3], TICK, axis=0)[1]
    return FlightAlone(flight.name, pos, ref, vel, normalised(resample(flight.t, flight.quat[:, 0], grid)[0]))


def compared_alone(
    flight: FlightAlone, vehicle: Vehicle, air: FlownAir, seeds: Sequence[int]
) -> ComparedAlone:
    """Return the errors of a flight and of its draws in an air."""
    rows = setpoint_rows(flight)
    error = flight.pos - flight.ref_pos
    drawn = np.stack([flown_positions(flight, rows, vehicle, air, seed) for seed in seeds]) - flight.ref_pos
    everywhere = np.ones(len(error), dtype=bool)
    x, y, z = (error_sums(error[:, k], drawn[..., k], everywhere, TICK, CLEAR_SHARE) for k in range(3))
    return ComparedAlone(flight.name, z, x + y)


def setpoint_rows(flight: FlightAlone) -> Array:
    """Return the setpoints as the controllers read them, (T, columns)."""
    angles = (0.0, 0.0, float(np.degrees(yaw_from_quat(flight.quat))))
    held = Setpoint(x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, attitude_deg=angles)
    return np.stack([setpoint_row(replace(held, pos=(x, y, z)), Power()) for x, y, z in flight.ref_pos])


def flown_positions(flight: FlightAlone, rows: Array, vehicle: Vehicle, air: FlownAir, seed: int) -> Array:
    """Return the positions of a draw [m], (T, 3)."""
    yaw = yaw_from_quat(flight.quat)
    swarm = Swarm(("cf1",), vehicle, np.append(flight.pos[0], yaw)[None], air, seed)
    swarm.state[0, VEL], swarm.state[0, QUAT] = flight.vel, flight.quat
    ambient = ambient_of_air(air, 1, seed)
    airframe = airframe_in(swarm, vehicle)
    controllers = fresh_controllers(airframe, 1)._replace(gains=Parameters(airframe).gains()[None])
    pos = np.empty((len(rows), 3))
    for k, row in enumerate(rows):
        pos[k] = swarm.state[0, POS]
        controllers.setpoints[:] = row
        fly_tick(swarm, controllers, ambient.drive())
    return pos
