"""Nearness over a flight, against plain numpy over all pairs."""

from itertools import combinations, permutations

import numpy as np
import pytest

from q2q_model.geometry.zone import Cylinder
from q2q_sim.monitors.metrics.proximity import (
    any_in_zone,
    in_zone_once,
    least_distances,
    near_sample,
    under_another,
)

ZONE = Cylinder(0.3, 0.5)


@pytest.fixture
def pos() -> np.ndarray:
    """Return five vehicles that drift about within a metre, one of them unknown at times, (T, 5, 3)."""
    rng = np.random.default_rng(5)
    drift = 0.1 * rng.standard_normal((200, 5, 3)).cumsum(axis=0) % 1.0
    drift[50:120, 2] = np.nan
    return drift


def test_every_pair_has_its_least_distance(pos: np.ndarray) -> None:
    found = least_distances(pos)
    for i, j in combinations(range(5), 2):
        apart = np.linalg.norm(pos[:, j] - pos[:, i], axis=1)
        assert found[i, j] == pytest.approx(np.nanmin(apart), rel=1e-15)
        assert found[j, i] == np.inf
    assert np.isinf(np.diag(found)).all()


def test_a_pair_that_is_never_known_has_no_least_distance(pos: np.ndarray) -> None:
    found = least_distances(pos[60:100])
    assert np.isinf(found[:, 2]).all()
    assert np.isinf(found[2]).all()
    assert np.isinf(least_distances(pos[:0])).all()


def test_ticks_in_the_zone_are_those_of_its_signed_distance(pos: np.ndarray) -> None:
    inside = [ZONE.signed_distance(pos[:, j] - pos[:, i]) < 0.0 for i, j in combinations(range(5), 2)]
    assert 0 < np.any(inside, axis=0).sum() < len(pos)
    np.testing.assert_array_equal(any_in_zone(pos, ZONE), np.any(inside, axis=0))
    few = pos[:12]
    once = [(ZONE.signed_distance(few[:, j] - few[:, i]) < 0.0).any() for i, j in combinations(range(5), 2)]
    assert 0 < sum(once) < len(once)
    assert in_zone_once(few, ZONE) == [
        pair for pair, is_so in zip(combinations(range(5), 2), once, strict=True) if is_so
    ]


def test_a_vehicle_is_near_any_sample_of_its_tick(pos: np.ndarray) -> None:
    samples = np.roll(pos, 7, axis=0)[:, :3]
    apart = np.linalg.norm(pos[:, :, None] - samples[:, None], axis=3)  # (T, vehicle, sample)
    assert 0 < (apart < 0.3).any(axis=2).sum() < 1000
    np.testing.assert_array_equal(near_sample(pos, samples, 0.3), (apart < 0.3).any(axis=2))


def test_under_another_is_below_it_and_beside_it_by_less_than_the_bounds(pos: np.ndarray) -> None:
    expected = np.zeros((200, 5), dtype=np.bool_)
    for i, j in permutations(range(5), 2):
        rel = pos[:, j] - pos[:, i]
        expected[:, i] |= (np.hypot(rel[:, 0], rel[:, 1]) < 0.3) & (rel[:, 2] > 0.0) & (rel[:, 2] < 0.6)
    assert 0 < expected.sum() < expected.size
    np.testing.assert_array_equal(under_another(pos, 0.3, 0.6), expected)
