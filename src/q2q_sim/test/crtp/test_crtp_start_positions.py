"""Vehicles that wait for clients stand on spots of their own."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from q2q_sim.crtp.fleet_room import CrtpRoomParams, fleet_in
from q2q_sim.crtp.start_positions import SPACING, spread_start_positions
from q2q_sim.loop.room import Room
from q2q_sim.scenarios import library


def nearest(spots: np.ndarray) -> float:
    gaps = np.linalg.norm(spots[:, None] - spots[None], axis=-1)
    return float(gaps[~np.eye(len(spots), dtype=bool)].min())


@pytest.mark.parametrize("name", ["swarm4", "swarm10", "swarm100"])
def test_a_swarm_whose_paths_begin_above_each_other_starts_apart(name: str) -> None:
    scenario = library.load(name)
    room = Room(scenario, seed=0)
    fleet_in(room, scenario, CrtpRoomParams())
    spots = room.swarm.state[:, :2]
    assert nearest(spots) >= SPACING - 1e-9
    assert (room.swarm.state[:, 2] == 0.0).all()
    expected = np.array([one.points[0][:2] for one in scenario.waypoints])
    np.testing.assert_array_equal(spots[::2], expected[::2])  # the lower ring stands below its waypoints
    moved = np.linalg.norm(spots[1::2] - expected[1::2], axis=1)
    assert (moved > 0.0).all()
    assert moved.max() <= 3.0 * SPACING


points = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))


@given(st.lists(points, min_size=2, max_size=30))
def test_any_crowd_is_put_apart(crowd: list[tuple[float, float]]) -> None:
    assert nearest(spread_start_positions(np.array(crowd))) >= SPACING * (1.0 - 1e-6)


def test_those_that_stand_apart_stay_where_they_are() -> None:
    spots = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, -0.41]])
    np.testing.assert_array_equal(spread_start_positions(spots), spots)
