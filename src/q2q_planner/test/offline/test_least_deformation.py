"""The smallest deformation past planes: its cost, its dual and the pairs that it watches."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from meeting_vehicles import PAPER
from scipy import sparse
from scipy.optimize import nnls
from section_4_1 import SECTION_4_1

from q2q_model.signals.values import Array
from q2q_planner.offline.avoidance.deviation_space import deform, deviation_space
from q2q_planner.offline.avoidance.least_deformation import least_deviations, nonnegative_qp
from q2q_planner.offline.avoidance.near_samples import LOOK
from q2q_planner.offline.avoidance.separating_planes import Planes, watch_pairs
from q2q_planner.offline.avoidance.swarm_samples import sample_swarm
from q2q_planner.offline.certificate.convex_zone import zone_around
from q2q_planner.offline.minimum_snap.minimum_snap import (
    minimum_snap,
    minimum_snap_plan,
    snap_cost,
)

DUALITY_GAP = 1e-8
"""Suboptimality at which PIQP stops (its default)."""


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10**6))
def test_cost_is_length_in_the_space_of_deviations(seed: int) -> None:
    for reading in ("stop_and_go", "free"):
        space = deviation_space(SECTION_4_1[0], reading, 4)
        y = np.random.default_rng(seed).normal(size=(space.dimension, 3)) * 0.01
        base = minimum_snap(SECTION_4_1[0], reading)
        curve = deform(base, space, y)
        assert snap_cost(curve) - snap_cost(base) == pytest.approx(float((y**2).sum()), rel=1e-6)
        t = np.linspace(0.0, 50.0, 23)
        assert curve.at(t)[:, :3] - base.at(t)[:, :3] == pytest.approx(space.rows(t) @ y, abs=1e-9)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 30))
def test_the_dual_is_that_of_nonnegative_least_squares_dense_and_sparse(seed: int, size: int) -> None:
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(size, size + 3))
    gram, asked = root @ root.T + 0.1 * np.eye(size), generator.normal(size=size)
    lower = np.linalg.cholesky(gram)
    exact = nnls(lower.T, np.linalg.solve(lower, asked))[0]

    def cost(x: Array) -> float:
        return float(x @ gram @ x / 2.0 - asked @ x)

    for matrix in (gram, sparse.csr_array(gram)):
        found = nonnegative_qp(matrix, asked)
        assert (found >= 0.0).all()
        assert cost(found) - cost(exact) <= DUALITY_GAP * (1.0 + abs(cost(exact)))


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 100))
def test_every_pair_near_the_zone_is_watched_and_no_other(seed: int, samples: int) -> None:
    """A pair near the zone for one sample is found among boxes of many; those watched before are kept."""
    generator = np.random.default_rng(seed)
    positions = np.cumsum(generator.normal(scale=0.05, size=(samples, 7, 3)), axis=0)
    positions += generator.uniform(-1.0, 1.0, (7, 3))
    pairs, hull = np.triu_indices(7, 1), zone_around(PAPER)
    before = generator.uniform(size=(21, samples)) < 0.02
    watch = watch_pairs(positions, pairs, hull, before)
    rel = positions[:, pairs[0]] - positions[:, pairs[1]]  # (S, 21, 3)
    wide, tall = PAPER.eps * (1.0 + LOOK), PAPER.d + LOOK * PAPER.eps
    near = ((np.hypot(rel[..., 0], rel[..., 1]) < wide) & (np.abs(rel[..., 2]) < tall)).T
    seen = np.zeros_like(before)
    seen[watch.pair, watch.sample] = True
    assert (seen <= near | before).all()
    assert (seen >= before).all()
    moved = np.sqrt((np.diff(rel, axis=0) ** 2).sum(-1)).min(initial=np.inf, axis=0)
    quick = moved > 0.25 * PAPER.eps  # all samples of these pairs are far enough apart for a plane each
    assert (seen == near | before)[quick].all()
    assert watch.rel == pytest.approx(rel[watch.sample, watch.pair])


def test_a_plane_that_is_not_touched_has_no_dual() -> None:
    """Of two planes across the way of a pair, the one 1 cm nearer holds it off and the other is loose."""
    spaces = [deviation_space(vehicle, "stop_and_go", 5) for vehicle in SECTION_4_1]
    samples = sample_swarm(minimum_snap_plan(SECTION_4_1), spaces, np.linspace(1.0, 49.0, 49))
    i, j, x = np.array([0, 0]), np.array([1, 1]), np.tile([1.0, 0.0, 0.0], (2, 1))
    rel_x = samples.base[10, 0, 0] - samples.base[10, 1, 0]
    planes = Planes(i, j, np.array([10, 10]), x, rel_x + np.array([0.05, 0.04]))
    deviations, dual = least_deviations(samples, planes, np.zeros(2))
    assert dual[0] > 0.0
    assert dual[1] == 0.0
    moved = samples.positions(deviations)[10, :, 0]
    assert moved[0] - moved[1] == pytest.approx(rel_x + 0.05, abs=1e-5)  # as soft as HARD
