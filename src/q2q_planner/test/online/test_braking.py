"""A pair that is proven to keep out does, at every time sampled; compiled loops do what the plain ones do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array
from q2q_planner.online.safe.choice.barrier import BarrierLaw, BarrierStates, filter_accelerations
from q2q_planner.online.safe.motion import traffic
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions, motion_after, stays_out
from q2q_planner.online.safe.stopping.broad_phase import Pairs, StoppingSpace, SweepLimits, broad_phase

BRAKE = 3.0
LAW = BrakingLaw(0.2, 1.1, BRAKE)
BARRIER = BarrierLaw(3, 0.2, 1.1, 4.0, 4.0, 0.5, 0.05, shares=False)


def random_motions(seed: int, n: int = 2) -> Motions:
    generator = np.random.default_rng(seed)
    pos = generator.uniform(-1.0, 1.0, (n, 3))
    vel, acc = generator.normal(size=(n, 3)), generator.normal(size=(n, 3))
    hold, growth = generator.uniform(0.0, 0.1, n), generator.uniform(0.0, 0.05, (n, 2)) * [1.0, seed % 2]
    return Motions(pos, vel, acc, hold, growth, np.zeros((n, 3)))


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**9))
def test_what_is_proven_is_true_at_every_sample(seed: int) -> None:
    motions = random_motions(seed)
    proven = stays_out(motions, 0, 1, LAW, 1e-3)
    zone, growth = Cylinder(*LAW[:2]), motions.growth.sum(axis=0)
    times = np.linspace(0.0, 2.5, 400)
    left = []
    for s in times:
        pos, _ = motion_after(motions, float(s), BRAKE)
        left.append(zone.signed_distance(pos[0] - pos[1]) - growth[0] - growth[1] * s)
    rest = max(
        motions.hold + np.linalg.norm(motions.vel + motions.acc * motions.hold[:, None], axis=1) / BRAKE
    )
    least = np.array(left)[times <= rest].min(initial=np.inf)
    if proven:
        assert least > 0.0
    if least > 0.05 and growth[1] == 0.0:  # 400 samples miss at most 6 ms of some 5 m/s: 3 cm
        assert proven


def test_some_random_motions_are_proven_and_some_are_not() -> None:
    """So that what is proven of them, and what is not, is tested above: nine of ten are."""
    proven = [stays_out(random_motions(seed), 0, 1, LAW, 1e-3) for seed in range(100)]
    assert 0.5 < np.mean(proven) < 1.0


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**9))
def test_compiled_and_plain_agree(seed: int) -> None:
    motions = random_motions(seed, 4)
    for i, j in ((0, 1), (2, 3), (0, 3)):
        assert stays_out(motions, i, j, LAW, 1e-3) == stays_out.py_func(motions, i, j, LAW, 1e-3)
    pairs = Pairs(np.array([0, 0, 1, 2]), np.array([1, 3, 2, 3]))
    states, wide = (
        BarrierStates(motions.pos, motions.vel, -motions.pos, np.full(3, -1.0)),
        np.full((4, 2), 0.1),
    )
    once, twice = motions.acc.copy(), motions.acc.copy()
    assert np.array_equal(
        filter_accelerations(once, states, pairs, wide, BARRIER),
        filter_accelerations.py_func(twice, states, pairs, wide, BARRIER),
    )
    assert once == pytest.approx(twice, rel=1e-12, abs=1e-12)  # the compiler may fuse
    assert np.array_equal(once[3], motions.acc[3])  # an external vehicle is not pushed


def test_braking_stops_after_v_squared_over_two_b() -> None:
    still = np.zeros((1, 3))
    motions = Motions(still, np.array([[3.0, 0.0, 0.0]]), still, np.zeros(1), np.zeros((1, 2)), still)
    pos, vel = motion_after(motions, 0.5, BRAKE)
    assert pos[0].tolist() == pytest.approx([3.0 * 0.5 - 0.5 * BRAKE * 0.25, 0.0, 0.0])
    assert vel[0].tolist() == pytest.approx([1.5, 0.0, 0.0])
    pos, vel = motion_after(motions, 9.0, BRAKE)
    assert pos[0, 0] == pytest.approx(3.0**2 / (2.0 * BRAKE))
    assert not vel.any()


@settings(max_examples=100)
@given(st.integers(0, 10**9), st.floats(0.1, 50.0))
def test_what_has_braked_rests_exactly(seed: int, brake: float) -> None:
    """After 99 s and after ticks of 10 ms: what rounding leaves of a velocity would have a direction."""
    motions = random_motions(seed, 20)._replace(hold=np.zeros(20))
    longest = float(np.linalg.norm(motions.vel, axis=1).max()) / brake
    assert not motion_after(motions, 99.0, brake)[1].any()
    for _ in range(int(longest / 0.01) + 2):
        motions = motions._replace(vel=motion_after(motions, 0.01, brake)[1])
    assert not motions.vel.any()


@settings(max_examples=200)
@given(st.integers(0, 10**9), st.floats(0.0, 3.0))
def test_braking_brings_no_two_velocities_further_apart(seed: int, s: float) -> None:
    """The fact on which the growth of external vehicles' zones rests."""
    motions = random_motions(seed)
    vel = motions.vel
    _, later = motion_after(motions._replace(hold=np.zeros(2)), s, BRAKE)
    assert np.linalg.norm(later[0] - later[1]) <= np.linalg.norm(vel[0] - vel[1]) + 1e-12


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**9))
def test_no_pair_that_could_matter_is_left_out(seed: int) -> None:
    """Every pair that the sweep leaves out is proven apart, and asks for no push."""
    pos, vel, acc, hold, growth, jerk = random_motions(seed, 12)
    pos *= 4.0
    fast = np.linalg.norm(vel, axis=1) + BRAKE * 0.1
    ways = (
        fast * (0.1 + 0.5 * fast / BRAKE) + growth[:, 0] + growth[:, 1] * (0.1 + (fast.max() + 0.1) / BRAKE)
    )
    space = StoppingSpace(ways, growth)
    limits = SweepLimits(12, 0.2, 1.1, 2.0, 2.0 * BRAKE)
    found = set(
        zip(
            *(rows.tolist() for rows in broad_phase(pos, vel, space, limits)),
            strict=True,
        )
    )
    bound = np.minimum(np.abs(acc), BRAKE / np.sqrt(3.0)) * np.sign(acc)
    for i in range(12):
        for j in range(i + 1, 12):
            if (i, j) in found:
                continue
            assert stays_out(Motions(pos, vel, bound, hold, growth, jerk), i, j, LAW, 0.0)
            turned, pair = bound.copy(), Pairs(np.array([i]), np.array([j]))
            wide = (growth[i] + growth[j])[None, :]
            assert not filter_accelerations(
                turned,
                BarrierStates(pos, vel, pos, np.full(12, -np.inf)),
                pair,
                wide,
                BARRIER._replace(own=12),
            ).any()


def motion_by_numpy(motions: Motions, s: float | Array, brake: float) -> tuple[Array, Array]:
    """Return position and velocity (n, 3) of n motions at time s [s]."""
    pos, vel, acc, hold, *_ = motions
    when = np.broadcast_to(s, hold.shape)[:, None]
    first = np.minimum(when, hold[:, None])
    there, moving = pos + vel * first + 0.5 * acc * first**2, vel + acc * first
    speed = np.sqrt((moving**2).sum(-1, keepdims=True))
    some = np.where(speed > 0.0, speed, 1.0)
    u = np.minimum(when - first, speed / brake)
    return there + moving * (u - 0.5 * brake * u**2 / some), moving * np.maximum(0.0, 1.0 - brake * u / some)


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**9))
def test_compiled_motions_are_those_of_numpy(seed: int) -> None:
    motions = random_motions(seed, 5)
    motions.vel[0], motions.acc[0] = 0.0, 0.0  # one at rest
    when = np.random.default_rng(seed).uniform(0.0, 2.0, 5)
    for s in (0.0, 0.3, when):
        for ours, twin in zip(
            motion_after(motions, s, BRAKE), motion_by_numpy(motions, s, BRAKE), strict=True
        ):
            assert ours == pytest.approx(twin, rel=1e-12, abs=1e-12)  # sums in another order


def pairs_by_numpy(pos: Array, vel: Array, space: StoppingSpace, limits: SweepLimits) -> set[tuple[int, int]]:
    """Return the pairs that can affect each other, by comparing all rows."""
    i, j = np.triu_indices(len(pos), 1)
    rel, moving, growth = pos[i] - pos[j], vel[i] - vel[j], space.growth[i] + space.growth[j]
    across = np.hypot(rel[:, 0], rel[:, 1])
    side, cap = across - limits.eps, np.abs(rel[:, 2]) - limits.d
    h = np.maximum(side, cap) - growth[:, 0]
    flat = np.maximum(0.0, -(rel[:, :2] * moving[:, :2]).sum(-1) / across)
    closing = np.where(cap > 0.0, np.abs(moving[:, 2]), 0.0) + np.where(side > 0.0, flat, 0.0) + growth[:, 1]
    stops = h > space.stopping_distances[i] + space.stopping_distances[j]
    slow = 2.0 * limits.pole * closing + limits.correction < limits.pole**2 * h
    kept = ~(stops & slow)
    return set(zip(i[kept].tolist(), j[kept].tolist(), strict=True))


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**9))
def test_the_reaches_of_the_sweep_leave_out_no_pair(seed: int) -> None:
    """Also of the fastest pairs that meet head on, of which one climbs."""
    generator = np.random.default_rng(seed)
    pos, vel = generator.uniform(-6.0, 6.0, (30, 3)), generator.normal(size=(30, 3))
    vel[:10] = -2.0 * pos[:10] / np.linalg.norm(pos[:10], axis=1, keepdims=True)
    growth = generator.uniform(0.0, 0.2, (30, 2))
    limits = traffic.limits_of(SafeReplannerParams(eps=0.2, tracking=0.02))
    rows = traffic.TrafficRows(pos, vel, growth)
    held = generator.uniform(limits.acc, 30.0, 30)
    found = traffic.interacting_pairs(30, rows, held, limits)
    space = StoppingSpace(traffic.stopping_distances(rows, held, limits), growth)
    sweep = SweepLimits(30, limits.eps, limits.d, limits.pole, 2.0 * limits.acc)
    every = pairs_by_numpy(pos, vel, space, sweep)
    assert set(zip(found.i.tolist(), found.j.tolist(), strict=True)) == every
    assert len(found.i) == len(every) < 30 * 29 // 2
