"""Corners of the zone that a pair cuts between two planes get planes, so that swaps around it are proven."""

import numpy as np
import pytest

from q2q_model.geometry.zone import Ellipsoid
from q2q_planner.experiments.crowded_room import RoomSize, random_swap
from q2q_planner.offline.avoidance.avoidance_params import AvoidanceParams
from q2q_planner.offline.avoidance.joint_plan import avoid_zones
from q2q_planner.offline.avoidance.near_samples import cut_corners
from q2q_planner.offline.certificate.convex_zone import zone_around

FLAT = Ellipsoid(0.38, 0.24)
"""Bends with a radius of 0.15 m at its rim."""
ROOM = RoomSize()


def test_the_deepest_sample_of_each_pass_is_found() -> None:
    """A pair passes twice, 0.1 and 0.2 m deep, another stays away."""
    t = np.linspace(-1.0, 1.0, 401)
    height = np.where(t < 0.0, 0.14, 0.04)
    still = np.zeros_like(t)
    first = np.stack([np.abs(np.abs(t) - 0.5) * 4.0, still, height], axis=-1)
    away = first + np.array([0.0, 5.0, 0.0])
    positions = np.stack([first, np.zeros_like(first), away], axis=1)  # (S, 3, 3)
    found = cut_corners(positions, np.triu_indices(3, 1), zone_around(FLAT))
    pair, sample = np.nonzero(found)
    assert pair.tolist() == [0, 0]
    assert t[sample] == pytest.approx([-0.5, 0.5], abs=1e-9)


def test_a_pair_outside_of_the_zone_cuts_no_corner() -> None:
    positions = np.zeros((50, 2, 3))
    positions[:, 1, 2] = 0.241
    assert not cut_corners(positions, np.triu_indices(2, 1), zone_around(FLAT)).any()


@pytest.mark.parametrize("seed", range(6))
def test_swaps_around_a_flat_zone_are_proven(seed: int) -> None:
    """Every pair is outside of the zone between the samples of the search, too: seen by 10 000 samples."""
    count = 11
    swarm = random_swap(count, FLAT, ROOM, np.random.default_rng([seed, count]))
    plan = avoid_zones(swarm, FLAT, params=AvoidanceParams(initial_guesses=1)).plan
    t = np.linspace(0.0, ROOM.time, 10_000)
    pos = np.stack([curve.at(t)[:, :3] for curve in plan.trajectories])
    i, j = np.triu_indices(count, 1)
    assert FLAT.signed_distance(pos[i] - pos[j]).min() > 0.0
