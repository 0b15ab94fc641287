"""Swarms of hovering vehicles in the air of a room, and its terms, for tests."""

import numpy as np

from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.air_terms import (
    AbsorptionTerm,
    EdgeTorqueTerm,
    GroundTerm,
    JetTerm,
    MeanderTerm,
    RateLoadTerm,
    ResidualTerm,
    RotorDragTerm,
    VehicleTerm,
    WindTerm,
)
from q2q_sim.air.room_air import RoomAir
from q2q_sim.plant.body.state_row import ETA_Z
from q2q_sim.plant.swarm import Swarm

GAPS = np.array([0.1, 0.2, 0.35, 0.5, 0.8])
RADII = np.array([0.0, 0.02, 0.05, 0.08, 0.12, 0.2])
PUSH = 2.5 * np.exp(-0.95 * (GAPS[:, None] - 0.4) - 0.5 * (RADII / 0.054) ** 2)
PUSH[:, -1] = 0.0
JET = JetTerm(GAPS, RADII, PUSH, upper_ratio=0.02, travel_speed_mps=7.5, carried=0.0, slope=0.0)
HOVER = CRAZYFLIE_2_0.hover_thrust
WHOLE = RoomAir(
    jet=JET,
    absorption=AbsorptionTerm(0.3, 0.06),
    meander=MeanderTerm(0.04, 0.3),
    residual=ResidualTerm(0.28, 0.1, 0.08),
    edge_torque=EdgeTorqueTerm(2e-3, 0.06),
    ground=GroundTerm(0.5, 0.023),
    wind=WindTerm((0.1, 0.0, 0.0), 0.05, 1.0),
    vehicle=VehicleTerm(0.1, 0.1, 0.06, 1.5, 0.1, 0.001),
    rotor_drag=RotorDragTerm(0.44),
    rate_load=RateLoadTerm(0.05),
)
"""Every term."""


def swarm_in(air: RoomAir, places: list[tuple[float, float, float]], seed: int = 0) -> Swarm:
    start = np.array([[*place, 0.0] for place in places])
    return Swarm(tuple(f"cf{i}" for i in range(len(places))), CRAZYFLIE_2_0, start, air, seed)


def hover(swarm: Swarm, steps: int) -> None:
    n = len(swarm.names)
    drive = np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0], (n, 1))
    swarm.step(np.tile([HOVER, 0.0, 0.0, 0.0], (steps, n, 1)), drive)


def held(swarm: Swarm, steps: int) -> Array:
    """Return the push on vehicles that are put back to their start after each step, (steps, n)."""
    start, pushes = swarm.state.copy(), []
    for _ in range(steps):
        pushes.append(swarm.downwash()[:, 2])
        hover(swarm, 1)
        swarm.state[:, :ETA_Z] = start[:, :ETA_Z]
    return np.array(pushes)
