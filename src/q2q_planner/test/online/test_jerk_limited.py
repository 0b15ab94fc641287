"""Fastest stops are those of textbooks, continue themselves, and pairs that are proven stay apart."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from q2q_model.geometry.zone import Cylinder
from q2q_model.signals.values import Array
from q2q_planner.online.safe.stopping.braking import BrakingLaw, Motions
from q2q_planner.online.safe.stopping.jerk_limited import (
    jerk_limited_motion_after,
    jerk_towards,
    rest_delay,
    rest_time,
    stop_reach,
    with_stops,
)
from q2q_planner.online.safe.stopping.jerk_limited_separation import stays_out_jerk_limited

BRAKE, JERK = 2.0, 20.0
LAW = BrakingLaw(0.2, 1.1, BRAKE, JERK)


def random_motions(seed: int, n: int = 2) -> Motions:
    """Return motions whose accelerations keep the bound while the jerk is held."""
    generator = np.random.default_rng(seed)
    pos, vel = generator.uniform(-1.0, 1.0, (n, 3)), generator.normal(size=(n, 3))
    acc, then = generator.uniform(-BRAKE, BRAKE, (2, n, 3))
    hold = generator.uniform(0.001, 0.1, n)
    jerk = np.clip((then - acc) / hold[:, None], -JERK, JERK)
    growth = generator.uniform(0.0, 0.05, (n, 2)) * [1.0, seed % 2]
    return Motions(pos, vel, acc, hold, growth, jerk)


def _over_time(motions: Motions, times: Array) -> tuple[Array, Array, Array]:
    """Return position, velocity and acceleration at every time, (T, n, 3) each."""
    states = [jerk_limited_motion_after(motions, float(s), LAW) for s in times]
    pos, vel, acc = (np.array([one[part] for one in states]) for part in range(3))
    return pos, vel, acc


def stopping(vel: float, acc: float) -> Motions:
    """Return one vehicle that stops at once, moving along x."""
    along = np.array([[1.0, 0.0, 0.0]])
    still = np.zeros((1, 3))
    return Motions(still, vel * along, acc * along, np.zeros(1), np.zeros((1, 2)), still)


def rest(motions: Motions, row: int) -> float:
    """Return the time at which a motion rests [s]."""
    return rest_time(with_stops(motions, LAW), row)


def proven_apart(motions: Motions, floor: float = 1e-3) -> bool:
    """Return whether the first two motions are proven to stay apart."""
    return stays_out_jerk_limited(with_stops(motions, LAW), 0, 1, LAW, floor)


def test_a_stop_from_2_m_per_s_takes_the_time_and_distance_of_its_trapezium() -> None:
    """Without initial acceleration: v / A + A / J, and half of v times that."""
    motion, end = stopping(2.0, 0.0), 2.0 / BRAKE + BRAKE / JERK
    assert rest(motion, 0) == pytest.approx(end, rel=1e-14)
    pos, vel, acc = jerk_limited_motion_after(motion, end, LAW)
    assert pos[0].tolist() == pytest.approx([0.5 * 2.0 * end, 0.0, 0.0], rel=1e-14)
    assert np.abs(vel).max() < 1e-14
    assert np.abs(acc).max() < 1e-13
    assert jerk_limited_motion_after(motion, 9.0, LAW)[0][0, 0] == pytest.approx(1.0 * end, rel=1e-14)


def test_a_stop_from_a_low_speed_takes_the_time_of_its_triangle() -> None:
    """Below v = A^2 / J the deceleration peaks at sqrt(J v): 2 sqrt(v / J)."""
    assert rest(stopping(-0.05, 0.0), 0) == pytest.approx(2.0 * np.sqrt(0.05 / JERK), rel=1e-14)


def test_a_motion_at_rest_stays() -> None:
    pos, vel, acc = jerk_limited_motion_after(stopping(0.0, 0.0), 1.0, LAW)
    assert not pos.any()
    assert not vel.any()
    assert not acc.any()


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**9))
def test_motions_keep_their_bounds_and_come_to_rest(seed: int) -> None:
    motions = random_motions(seed)
    end = max(rest(motions, row) for row in range(2))
    times = np.linspace(0.0, end, 500)
    pos, vel, acc = _over_time(motions, times)
    step = times[1]
    assert np.abs(acc).max() <= BRAKE * (1.0 + 1e-9)
    assert np.abs(np.diff(acc, axis=0)).max() <= JERK * step * (1.0 + 1e-6)
    # of a cubic the trapezoidal rule is wrong by J step^3 / 12; twice that where the jerk changes
    most = JERK * (1.0 + 1e-9)  # attained where it changes midway
    assert np.abs(np.diff(pos, axis=0) - 0.5 * step * (vel[1:] + vel[:-1])).max() <= most * step**3 / 4.0
    assert np.abs(np.diff(vel, axis=0) - 0.5 * step * (acc[1:] + acc[:-1])).max() <= most * step**2 / 4.0
    assert np.abs(vel[-1]).max() < 1e-9
    assert np.abs(acc[-1]).max() < 1e-6


@settings(deadline=None, max_examples=100)
@given(st.integers(0, 10**9), st.floats(0.0, 2.0), st.floats(0.0, 2.0))
@example(1265, 0.109375, 1.0)  # continued where the deceleration ends
def test_the_rest_of_a_motion_is_the_motion_of_its_rest(seed: int, first: float, then: float) -> None:
    motions = random_motions(seed)
    pos, vel, acc = jerk_limited_motion_after(motions, first, LAW)
    left = np.maximum(motions.hold - first, 0.0)
    rest = motions._replace(pos=pos, vel=vel, acc=acc, hold=left)
    for one, other in zip(
        jerk_limited_motion_after(motions, first + then, LAW)[:2],
        jerk_limited_motion_after(rest, then, LAW)[:2],
        strict=True,
    ):
        # the peak is a root: a rounding of 1e-16 in its square moves it by 1e-8
        np.testing.assert_allclose(one, other, atol=1e-7)


@settings(deadline=None, max_examples=200)
@given(st.integers(0, 10**9), st.floats(0.0, 3.0))
def test_stops_bring_no_two_velocities_further_apart_on_any_axis(seed: int, s: float) -> None:
    """The fact on which growth at the rate g1 rests."""
    motions = random_motions(seed)
    same = motions._replace(hold=np.zeros(2), acc=np.repeat(motions.acc[:1], 2, axis=0))
    _, later, _ = jerk_limited_motion_after(same, s, LAW)
    before = np.abs(motions.vel[0] - motions.vel[1])
    assert (np.abs(later[0] - later[1]) <= before + 1e-9).all()


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**9))
def test_what_is_proven_is_true_at_every_sample(seed: int) -> None:
    motions = random_motions(seed)
    proven = proven_apart(motions)
    zone, growth = Cylinder(*LAW[:2]), motions.growth.sum(axis=0)
    late = max(rest(motions, row) for row in range(2)) + rest_delay(float(growth[1]), LAW)
    left = []
    for s in np.linspace(0.0, late, 400):
        pos, _, _ = jerk_limited_motion_after(motions, float(s), LAW)
        left.append(zone.signed_distance(pos[0] - pos[1]) - growth[0] - growth[1] * s)
    least = min(left)
    if proven:
        assert least > 0.0
    if least > 0.05:  # 400 samples of 3 s miss 4 ms at some 5 m/s on each side: 4 cm
        assert proven


def test_some_random_motions_are_proven_and_some_are_not() -> None:
    """So that what is proven of them, and what is not, is tested above: nine of ten are."""
    proven = [proven_apart(random_motions(seed)) for seed in range(100)]
    assert 0.5 < np.mean(proven) < 1.0


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**9))
def test_compiled_and_plain_agree(seed: int) -> None:
    motions = random_motions(seed, 4)
    for i, j in ((0, 1), (2, 3), (0, 3)):
        given = with_stops(motions, LAW), i, j, LAW, 1e-3
        assert stays_out_jerk_limited(*given) == stays_out_jerk_limited.py_func(*given)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**9))
def test_nothing_moves_beyond_its_reach(seed: int) -> None:
    motions = random_motions(seed, 4)
    longest = max(rest(motions, row) for row in range(4))
    there, _, _ = jerk_limited_motion_after(motions, longest, LAW)
    moved = np.sqrt(((there - motions.pos) ** 2).sum(-1)) + motions.growth @ [1.0, longest]
    assert (moved <= stop_reach(with_stops(motions, LAW), LAW, longest)).all()


def test_a_velocity_known_less_well_takes_longer_to_stop_by_two_ramps_and_a_plateau() -> None:
    assert rest_delay(0.2, LAW) == pytest.approx(0.2 / BRAKE + 2.0 * np.sqrt(0.2 / JERK), rel=1e-14)
    for vel in (0.0, 0.1, 1.0, 3.0):
        later = rest(stopping(vel + 0.2, 0.0), 0) - rest(stopping(vel, 0.0), 0)
        assert later <= rest_delay(0.2, LAW)


@pytest.mark.parametrize(("jerk", "most"), [(0.0, BRAKE), (30.0, 4.0), (-30.0, BRAKE)])
def test_the_reach_of_a_stop_is_its_largest_speed_for_its_time_and_its_doubt(
    jerk: float, most: float
) -> None:
    """An acceleration of 1 m/s^2 becomes 4 or -2 m/s^2 within its hold; the other axes have the brake's."""
    hold, longest = 0.1, 2.0
    along, still = np.array([[1.0, 0.0, 0.0]]), np.zeros((1, 3))
    motion = Motions(still, 1.5 * along, along, np.array([hold]), np.array([[0.1, 0.2]]), jerk * along)
    bound = np.sqrt(most**2 + 2.0 * BRAKE**2)
    speed = 1.5 + bound * (hold + bound / JERK)
    late = longest + rest_delay(0.2, LAW)
    reach = speed * rest(motion, 0) + 0.1 + 2.0 * 0.2 * late
    assert stop_reach(with_stops(motion, LAW), LAW, longest).tolist() == [pytest.approx(reach, rel=1e-13)]


def test_a_jerk_leads_to_the_wanted_acceleration_within_its_lag_and_bound() -> None:
    desired, acc = np.array([[1.0, -1.0, 0.5]]), np.array([[0.0, 1.0, 0.5]])
    assert jerk_towards(desired, acc, 0.25, 100.0).tolist() == [[4.0, -8.0, 0.0]]
    assert jerk_towards(desired, acc, 0.25, 5.0).tolist() == [[4.0, -5.0, 0.0]]


def pair(rel_pos: Array, vel: Array, acc: Array | None = None, hold: float = 0.0) -> Motions:
    """Return two motions: the first at `rel_pos` from the second; velocities and accelerations are (2, 3)."""
    pos, zero = np.array([rel_pos, np.zeros(3)]), np.zeros((2, 3))
    return Motions(pos, vel, zero if acc is None else acc, np.full(2, hold), np.zeros((2, 2)), zero)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_vehicles_that_fly_through_each_other_are_not_proven_apart(axis: int, sign: float) -> None:
    """Head-on at 12 m/s, they are in each other's zone for hundredths of a second."""
    towards = np.zeros(3)
    towards[axis] = sign
    apart = (LAW.d if axis == 2 else LAW.eps) + 1.0
    assert not proven_apart(pair(-apart * towards, np.array([6.0 * towards, -6.0 * towards])))
    assert proven_apart(pair(-apart * towards, np.array([-6.0 * towards, 6.0 * towards])))


@pytest.mark.parametrize("speed", [0.5, 2.0, 6.0])
def test_who_passes_is_proven_apart_exactly_where_it_stays_out_of_the_zone(speed: float) -> None:
    """It passes the other's axis at y, which is its smallest distance."""
    vel = np.array([[speed, 0.0, 0.0], [0.0, 0.0, 0.0]])
    start = -0.25 * speed / BRAKE * speed  # half of its way to rest
    for outside in (5e-3, 2e-2):
        assert proven_apart(pair(np.array([start, LAW.eps + outside, 0.0]), vel))
    for within in (-0.9e-3, 1e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2):  # the first: less than the floor away
        near = np.array([start, LAW.eps - within, 0.0])
        assert not proven_apart(pair(near, vel))


def test_accelerations_towards_each_other_count_even_without_speed() -> None:
    """Each goes 0.16 m in its hold and as far again: 0.1 m are too few, 1 m are not."""
    acc = np.array([[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]])
    for left, proven in ((0.1, False), (1.0, True)):
        motions = pair(np.array([-LAW.eps - left, 0.0, 0.0]), np.zeros((2, 3)), acc, hold=0.4)
        assert proven_apart(motions) == proven


def test_who_is_nearer_than_the_floor_already_may_part_but_not_come_nearer() -> None:
    for speed, proven in ((1.0, True), (0.0, True), (-0.01, False)):
        vel = np.array([[speed, 0.0, 0.0], [0.0, 0.0, 0.0]])
        start = np.array([LAW.eps + 5e-4, 0.0, 0.0])
        assert proven_apart(pair(start, vel)) == proven


def test_a_pair_that_takes_too_many_steps_is_not_proven() -> None:
    """Side by side at 1e-9 m from the zone, every step is some microseconds."""
    vel = np.tile([3.0, 0.0, 0.0], (2, 1))
    assert not proven_apart(pair(np.array([0.0, LAW.eps + 1e-9, 0.0]), vel), floor=0.0)


def test_a_doubt_that_grows_brings_vehicles_together_until_both_certainly_rest() -> None:
    """1.0 m/s is stopped within 0.6 s, 0.1 m/s more within 0.19 s: the zone grows by 79 mm."""
    vel = np.tile([1.0, 0.0, 0.0], (2, 1))
    grown = 0.1 * (1.0 / BRAKE + BRAKE / JERK + rest_delay(0.1, LAW))
    for left, proven in ((grown + 5e-3, True), (grown - 5e-3, False)):
        motions = pair(np.array([0.0, LAW.eps + left, 0.0]), vel)._replace(
            growth=np.array([[0.0, 0.1], [0.0, 0.0]])
        )
        assert proven_apart(motions) == proven
