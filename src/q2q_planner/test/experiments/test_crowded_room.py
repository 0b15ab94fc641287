"""A random swap starts and ends clear of the zone and within the walls, and is held only if it stays so."""

from dataclasses import replace

import numpy as np
import pytest

from q2q_model.geometry.zone import Ellipsoid
from q2q_model.vehicle.constants import CRAZYFLIE_2_1
from q2q_planner.experiments.crowded_room import CrowdedError, RoomSize, plan_swap, random_swap
from q2q_planner.offline.certificate.certificate import certify

ROOM = RoomSize()
ZONE = Ellipsoid(0.24, 0.6)


def test_a_swap_permutes_places_that_are_apart_and_within_the_walls() -> None:
    swarm = random_swap(8, ZONE, ROOM, np.random.default_rng(0))
    ends = np.array([[waypoint.pos for waypoint in vehicle.waypoints] for vehicle in swarm])  # (8, 2, 3)
    assert sorted(map(tuple, ends[:, 0])) == sorted(map(tuple, ends[:, 1]))
    assert (ends >= ROOM.inset).all()
    assert (ends <= ROOM.size - ROOM.inset).all()
    i, j = np.triu_indices(8, 1)
    assert (ZONE.signed_distance(ends[i, 0] - ends[j, 0]) > 0.0).all()


def test_a_held_plan_is_certified_and_walls_and_thrust_are_heeded() -> None:
    swarm = random_swap(4, ZONE, ROOM, np.random.default_rng(1))
    plan = plan_swap(swarm, ZONE, ROOM, (CRAZYFLIE_2_1, 3.0))
    assert plan is not None
    assert certify(plan, ZONE).holds
    assert plan_swap(swarm, ZONE, replace(ROOM, wall=0.9), (CRAZYFLIE_2_1, 3.0)) is None
    assert plan_swap(swarm, ZONE, ROOM, (CRAZYFLIE_2_1, 6.5)) is None  # all that it has to spare


def test_a_room_that_is_full_says_so() -> None:
    with pytest.raises(CrowdedError, match="vehicles at rest leave no room for another"):
        random_swap(4, Ellipsoid(5.0, 5.0), ROOM, np.random.default_rng(2))
