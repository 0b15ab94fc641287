"""The compiled swarm and its plain numpy twin give the same numbers."""

import numpy as np
import pytest

from q2q_model.vehicle.constants import CRAZYFLIE_2_0, TEXTBOOK_065, Vehicle
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.plant.body.state_row import ETA_Z
from q2q_sim.plant.swarm import Swarm
from q2q_sim.plant.swarm_air import still_air
from swarm_numpy import run_numpy


def _busy_swarm(vehicle: Vehicle, wake: WakeLaw, seed: int) -> tuple[Swarm, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    n, steps = 7, 150
    start = np.column_stack([rng.uniform(0.0, 0.6, (n, 2)), rng.uniform(0.02, 2.0, n), rng.uniform(-3, 3, n)])
    swarm = Swarm(tuple(f"cf{i}" for i in range(1, n + 1)), vehicle, start, wake)
    swarm.state[:, 3:6] = rng.normal(0.0, 0.7, (n, 3))
    swarm.state[:, 10:13] = rng.normal(0.0, 2.0, (n, 3))
    commands = np.empty((steps, n, 4))
    commands[..., 0] = rng.uniform(0.0, 2.5, (steps, n)) * vehicle.hover_thrust
    commands[..., 1:] = rng.normal(0.0, 1.0, (steps, n, 3))  # enough to saturate rotors
    commands[:20, 0, 0] = 0.0  # motors off
    drive = np.hstack([rng.normal(0.0, 0.5, (n, 3)), rng.uniform(0.8, 1.0, (n, 4))])
    return swarm, commands, drive


@pytest.mark.parametrize("wake", list(WakeLaw))
@pytest.mark.parametrize("vehicle", [CRAZYFLIE_2_0, TEXTBOOK_065], ids=lambda vehicle: vehicle.name)
def test_compiled_and_plain_swarm_move_alike(vehicle: Vehicle, wake: WakeLaw) -> None:
    swarm, commands, drive = _busy_swarm(vehicle, wake, seed=3)
    state = swarm.state.copy()
    air = still_air(state, wake, swarm.body)
    air.ring[:] = swarm.air.ring
    start = state.copy()
    swarm.step(commands, drive)
    run_numpy(state, air, commands, drive, swarm.body)
    assert np.abs(state[:, :ETA_Z] - start[:, :ETA_Z]).max() > 1.0
    if wake != WakeLaw.NONE:
        assert np.abs(state[:, ETA_Z]).max() > 0.1
    # rounding of 2e-16 a step of values up to 100, which a stable attitude loop does not let grow
    np.testing.assert_allclose(swarm.state, state, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(swarm.air.ring, air.ring, rtol=1e-12, atol=1e-12)
