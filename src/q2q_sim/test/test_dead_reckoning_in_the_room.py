"""Dead reckoning of unobserved vehicles against the vehicles of a room."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_control.failsafe.dead_reckoned_braking import DeadReckonedBraking
from q2q_model.signals.values import CommandStatus, SwarmCommand
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY
from q2q_sim.loop.room import Room
from q2q_sim.plant.disturbance import DisturbanceParams
from q2q_sim.scenarios import library
from q2q_sim.scenarios.settings import REAL

HOVER = CRAZYFLIE_2_0.hover_thrust


def _asked(room: Room, thrust: float, roll: float) -> SwarmCommand:
    n = len(room.names)
    status = np.full(n, CommandStatus.DEGRADED, dtype=np.uint8)
    return SwarmCommand(
        room.capture().truth.t,
        room.names,
        np.full(n, thrust),
        np.full(n, roll),
        np.zeros(n),
        np.zeros(n),
        status,
    )


@pytest.mark.parametrize(("share", "roll"), [(1.0, 0.1), (1.1, 0.0)], ids=["tilt", "thrust"])
def test_commands_take_the_time_that_is_reckoned_with(share: float, roll: float) -> None:
    """A second after a step of the command, velocities differ by the step times the error of the lag."""
    radio = replace(REAL.radio, loss=0.0, quantised=False)
    scenario = replace(
        library.load("table2_3"),
        vehicle=CRAZYFLIE_2_0, vicon=REAL.vicon, radio=radio, disturbance=DisturbanceParams(),
    )  # fmt: skip
    room, block = Room(scenario, seed=0), DeadReckonedBraking(HOVER)
    block.update(room.capture().truth, _asked(room, HOVER, 0.0))
    for _ in range(100):
        asked = _asked(room, share * HOVER / np.cos(roll), roll)
        block.advance(None, None, asked.t)
        block.update(None, asked)
        room.advance(asked)
    truth = room.capture().truth
    block.advance(None, None, truth.t)
    unseen = replace(truth, status=np.full(len(room.names), 1, dtype=np.uint8), vel=np.zeros_like(truth.vel))
    reckoned = block.predicted(unseen).vel
    step = GRAVITY * (abs(np.sin(roll)) + share - 1.0)
    # the tick in which the step is given, and what the attitude loop overshoots
    np.testing.assert_allclose(reckoned, truth.vel, atol=step * 0.02)
    assert np.abs(truth.vel).max() > 0.7 * step
