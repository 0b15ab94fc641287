"""Many swarms in one call move as each of them alone."""

import re

import numpy as np
import pytest

from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.air.room_air import RoomAir
from q2q_sim.air.wake import AirSetup, Push, Sources
from q2q_sim.air.wake_laws import WakeLaw
from q2q_sim.plant.body.state_row import ETA_Z
from q2q_sim.plant.swarm import Swarm
from q2q_sim.plant.swarm_batch import SwarmBatch, SwarmBatchSetup

SWARMS, COUNT = 5, 3
SEEDS = (4, 0, 7, 1, 2)
CALLS, STEPS = 5, 130
"""650 steps: beyond the first block of the random processes, which ends within a call."""


def _start() -> np.ndarray:
    rng = np.random.default_rng(1)
    places = rng.uniform(-0.2, 0.2, (SWARMS, COUNT, 4))
    places[..., 2] = 3.0 + 0.4 * np.arange(COUNT)
    return places


@pytest.mark.parametrize("threads", [1, 2, 8])
@pytest.mark.parametrize("name", ["room", "measured", "paper", "none"])
def test_swarms_stepped_together_move_as_each_alone_to_the_last_bit(name: str, threads: int) -> None:
    air, start, rng = find_air(name), _start(), np.random.default_rng(2)
    assert isinstance(air, WakeLaw | RoomAir)
    batch = SwarmBatch(SwarmBatchSetup(CRAZYFLIE_2_0, start, air, SEEDS), threads)
    names = tuple(f"cf{i + 1}" for i in range(COUNT))
    swarms = [Swarm(names, CRAZYFLIE_2_0, one, air, seed) for one, seed in zip(start, SEEDS, strict=True)]
    drive = np.concatenate([rng.normal(0.0, 0.1, (SWARMS, COUNT, 3)), np.ones((SWARMS, COUNT, 4))], axis=2)
    for _ in range(CALLS):
        commands = rng.normal(0.0, 0.1, (STEPS, SWARMS, COUNT, 4))
        commands[..., 0] += CRAZYFLIE_2_0.hover_thrust
        batch.step(commands, drive)
        for k, swarm in enumerate(swarms):
            swarm.step(np.ascontiguousarray(commands[:, k]), drive[k])
    np.testing.assert_array_equal(batch.state, [swarm.state for swarm in swarms])
    assert (np.abs(batch.state[..., ETA_Z]).max() > 0.05) == (name != "none")


def test_swarms_without_seeds_have_those_of_their_numbers() -> None:
    air = find_air("room")
    assert isinstance(air, RoomAir)
    flown = [
        SwarmBatch(SwarmBatchSetup(CRAZYFLIE_2_0, _start(), air, seeds)) for seeds in ((), range(SWARMS))
    ]
    for batch in flown:
        batch.step(np.zeros((2, SWARMS, COUNT, 4)), np.zeros((SWARMS, COUNT, 7)))
    np.testing.assert_array_equal(flown[0].state, flown[1].state)


@pytest.mark.parametrize(
    ("swarms", "vehicles", "seeds", "threads"), [(0, 2, 0, 1), (2, 0, 2, 1), (2, 2, 3, 1), (2, 2, 2, 0)]
)
def test_impossible_batches_are_refused(swarms: int, vehicles: int, seeds: int, threads: int) -> None:
    setup = SwarmBatchSetup(CRAZYFLIE_2_0, np.zeros((swarms, vehicles, 4)), seeds=range(seeds))
    with pytest.raises(ValueError, match=f"{swarms} swarms of {vehicles} vehicles"):
        SwarmBatch(setup, threads)


@pytest.mark.parametrize("shape", [(COUNT, 4), (SWARMS, COUNT, 3), (4,)])
def test_a_start_of_another_shape_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(
        ValueError, match=re.escape(f"start of shape {shape} is given; must be (swarms, vehicles")
    ):
        SwarmBatch(SwarmBatchSetup(CRAZYFLIE_2_0, np.ones(shape)))


def test_commands_of_another_shape_are_refused() -> None:
    batch = SwarmBatch(SwarmBatchSetup(CRAZYFLIE_2_0, _start()))
    with pytest.raises(ValueError, match=r"commands \(2, 5, 2, 4\)"):
        batch.step(np.zeros((2, SWARMS, COUNT - 1, 4)), np.zeros((SWARMS, COUNT, 7)))


class Upwards:
    """Air of a user's own, outside the compiled loop."""

    def reset(self, setup: AirSetup) -> None:
        """Remember the number of vehicles."""
        self.push_all = np.tile([0.0, 0.0, 5.0], (setup.count, 1))

    def push(self, _: Sources) -> Push:
        """Push all upwards."""
        return Push(self.push_all, 0.0 * self.push_all)


@pytest.mark.parametrize("air", ["room", 1, Upwards()])
def test_an_air_that_a_batch_cannot_step_is_refused(air: object) -> None:
    with pytest.raises(TypeError, match="must be a WakeLaw or a RoomAir"):
        SwarmBatch(SwarmBatchSetup(CRAZYFLIE_2_0, _start(), air))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["room", "measured"])
def test_no_commands_move_nothing(name: str) -> None:
    air = find_air(name)
    assert isinstance(air, WakeLaw | RoomAir)
    batch = SwarmBatch(SwarmBatchSetup(CRAZYFLIE_2_0, _start(), air))
    before = batch.state.copy()
    batch.step(np.zeros((0, SWARMS, COUNT, 4)), np.zeros((SWARMS, COUNT, 7)))
    np.testing.assert_array_equal(batch.state, before)
