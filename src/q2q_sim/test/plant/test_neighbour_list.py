"""Lists of near vehicles change no result, whenever they are made; what they read is found where it is."""

import numpy as np
import pytest

from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.air.room_air import RoomAir
from q2q_sim.plant.body.state_row import ETA_Z, VEL
from q2q_sim.plant.push.neighbour_list import NEIGHBOURS, NeighbourList, empty_list
from q2q_sim.plant.push.push_table import cell, knots_of
from q2q_sim.plant.push.state_history_ring import LINE, ROOM_WIDTH, empty_ring
from q2q_sim.plant.swarm import Swarm

STEPS = 150
"""0.3 s: vehicles of 1 m/s go twice as far as a list allows."""


def _swarm(count: int, side: float, seed: int) -> Swarm:
    """Return vehicles that fly about in a cube."""
    air, rng = find_air("room"), np.random.default_rng(seed)
    assert isinstance(air, RoomAir)
    start = np.column_stack([rng.uniform(0.0, side, (count, 3)), np.zeros(count)])
    start[:, 2] += 2.0
    swarm = Swarm(tuple(f"cf{i}" for i in range(count)), CRAZYFLIE_2_0, start, air, seed)
    swarm.state[:, VEL] = rng.normal(0.0, 1.0, (count, 3))
    return swarm


def _fly(swarm: Swarm, *, anew: bool = False) -> np.ndarray:
    """Return the states after STEPS steps; `anew` rebuilds the list at each."""
    count = len(swarm.names)
    command = np.tile([CRAZYFLIE_2_0.hover_thrust, 0.05, 0.0, 0.0], (1, count, 1))
    drive = np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0], (count, 1))
    for _ in range(STEPS):
        if anew:
            swarm.air.room.near.limits[:] = -1.0
        swarm.step(command, drive)
    return swarm.state


@pytest.mark.parametrize(("count", "side"), [(12, 1.0), (7, 0.8), (40, 3.0)])
def test_a_list_kept_and_one_made_at_each_step_give_the_same_to_the_last_bit(count: int, side: float) -> None:
    kept, made = _fly(_swarm(count, side, seed=1)), _fly(_swarm(count, side, seed=1), anew=True)
    np.testing.assert_array_equal(kept, made)
    assert np.abs(kept[:, ETA_Z]).max() > 0.05


def test_a_list_with_too_few_places_gives_the_same_as_one_with_enough() -> None:
    """More vehicles than a list has places for are in a cube that all of them reach."""
    count = NEIGHBOURS + 10
    few, enough = _swarm(count, 0.5, seed=2), _swarm(count, 0.5, seed=2)
    places = np.zeros(count * count, dtype=np.intp)
    near = enough.air.room.near._replace(found=places)
    enough.air = enough.air._replace(room=enough.air.room._replace(near=near))
    np.testing.assert_array_equal(few.downwash(), enough.downwash())
    assert few.air.room.near.limits[0] < 0.0 < enough.air.room.near.limits[0]
    np.testing.assert_array_equal(_fly(few), _fly(enough))


def test_a_vehicle_that_is_put_elsewhere_is_found_there() -> None:
    swarm = _swarm(2, 0.0, seed=0)
    swarm.state[:, :3] = [[0.0, 0.0, 2.0], [50.0, 0.0, 2.5]]
    assert abs(swarm.downwash()[0, 2]) < 0.01  # of the ground
    swarm.state[1, 0] = 0.0
    swarm.air.ring[:, 1, :3] = swarm.state[1, :3]
    assert swarm.downwash()[0, 2] < -0.5


def test_a_list_of_one_vehicle_has_room_for_none() -> None:
    assert isinstance(empty_list(1), NeighbourList)
    assert empty_list(1).found.size == 1


def test_a_row_of_a_ring_fills_a_line_of_the_cache() -> None:
    ring = empty_ring((3, 5, ROOM_WIDTH))
    assert {row.ctypes.data % LINE for slot in ring for row in slot} == {0}
    assert ring.flags.c_contiguous


@pytest.mark.parametrize("at", [[0.1, 0.2, 0.35, 0.5, 0.8], [0.0, 1e-5, 1.0], [0.0, 0.05, 0.1, 0.15, 0.3]])
def test_the_cell_of_a_value_is_the_last_that_begins_below_it(at: list[float]) -> None:
    knots = np.array(at)
    values = np.concatenate([knots, np.linspace(0.0, 2.0 * knots[-1], 997)])
    expected = np.clip(np.searchsorted(knots, values) - 1, 0, len(knots) - 2)
    assert [cell(knots_of(knots), value) for value in values] == expected.tolist()
