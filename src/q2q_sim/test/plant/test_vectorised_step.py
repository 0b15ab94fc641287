"""Vehicles stepped in blocks move as those stepped alone, to the last bit."""

import numpy as np
import pytest

from q2q_control.attitude.attitude_law import AttitudeParams
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, TEXTBOOK_065, Vehicle
from q2q_sim.plant.body.quadcopter import advance, body_of
from q2q_sim.plant.body.rigid_body import SMALL_SQUARE, half_turn_squared
from q2q_sim.plant.body.state_row import ETA_Z, QUAT, RATE, ROTOR_MAX1, ROTORS, VEL, Z, state_at_rest
from q2q_sim.plant.body.vectorised_step import BLOCK_WIDTH, LANES, VALID, advance_rows

STEP = 0.002


@pytest.mark.parametrize("count", [2, 8, 9, 100])
@pytest.mark.parametrize("vehicle", [CRAZYFLIE_2_0, TEXTBOOK_065], ids=lambda vehicle: vehicle.name)
def test_a_block_advances_its_rows_as_one_vehicle_is_advanced(vehicle: Vehicle, count: int) -> None:
    rng = np.random.default_rng(count)
    body = body_of(vehicle, AttitudeParams(), STEP)
    start = np.column_stack([rng.uniform(-2, 2, (count, 2)), rng.uniform(0, 0.3, count), np.zeros(count)])
    state = state_at_rest(start, vehicle.mass)
    state[:, VEL] = rng.normal(0.0, 1.0, (count, 3))  # some meet the ground
    state[:, QUAT] = rng.normal([0.0, 0.0, 0.0, 1.0], 0.1, (count, 4))
    state[:, QUAT] /= np.linalg.norm(state[:, QUAT], axis=1, keepdims=True)
    state[:, RATE] = rng.normal(0.0, 0.5, (count, 3))
    state[::5, RATE] *= 60.0  # beyond the series
    state[:, ROTORS] = rng.uniform(0.2, 0.3, (count, 4)) * vehicle.hover_thrust
    state[:, ETA_Z:ROTOR_MAX1] = rng.normal(0.0, 1e-4, (count, ROTOR_MAX1 - ETA_Z))
    state[:, ROTOR_MAX1:] = rng.uniform(0.2, 0.6, (count, 4)) * vehicle.hover_thrust
    drive = np.hstack([rng.normal(0.0, 0.5, (count, 3)), rng.uniform(0.8, 1.0, (count, 4))])
    alone, work = state.copy(), (np.zeros(BLOCK_WIDTH * LANES), np.zeros(4))
    seen: set[float] = set()
    for _ in range(60):
        command = rng.normal([1.0, 0.0, 0.0, 0.0], 0.05, (count, 4))
        command[:, 0] *= vehicle.hover_thrust
        command[rng.random(count) < 0.05] = 0.0  # motors off
        advance_rows(state, command, drive, body, work)
        seen |= set(work[0].reshape(BLOCK_WIDTH, LANES)[VALID, :count])
        for row, one, air in zip(alone, command, drive, strict=True):
            advance(row, tuple(one), air, body, np.zeros(4))
        np.testing.assert_array_equal(state, alone)
    assert seen == {0.0, 1.0}  # both ways were taken


def test_what_a_block_cannot_do_is_stepped_alone() -> None:
    """Of five rows one is free; the others stop, stand, saturate, and turn fast."""
    vehicle = CRAZYFLIE_2_0
    body = body_of(vehicle, AttitudeParams(), STEP)
    state = state_at_rest(np.tile([0.0, 0.0, 1.0, 0.0], (5, 1)), vehicle.mass)
    commands = np.tile([vehicle.hover_thrust, 0.0, 0.0, 0.0], (5, 1))
    commands[1, 0] = 0.0
    state[2, Z], state[2, VEL] = 0.0, [0.0, 0.0, -1.0]
    commands[3, 0] = 10.0 * vehicle.thrust_max
    state[4, RATE] = [0.0, 0.0, 40.0]
    assert half_turn_squared((0.0, 0.0, 40.0), STEP) > SMALL_SQUARE
    work = (np.zeros(BLOCK_WIDTH * LANES), np.zeros(4))
    advance_rows(state, commands, np.tile([0.0] * 3 + [1.0] * 4, (5, 1)), body, work)
    assert work[0].reshape(BLOCK_WIDTH, LANES)[VALID, :5].tolist() == [1.0, 0.0, 0.0, 0.0, 0.0]
    assert state[2, Z] == 0.0
