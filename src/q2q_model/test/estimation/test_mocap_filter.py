"""The mocap filter on good, bad and missing samples of positions and attitudes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mocap_frames import (
    COAST_S,
    COASTING,
    IDEAL_SENSING,
    LOST,
    PAIR,
    TRACKED,
    flown_until,
    frame_at,
    time_of,
    truth_at,
)

from q2q_model.estimation.attitude.attitude_tracks import measured_attitudes
from q2q_model.estimation.mocap_filter import MocapFilter
from q2q_model.estimation.mocap_filter_params import MocapFilterParams
from q2q_model.geometry.rotations import identity_quat, quat_from_euler, quat_multiply
from q2q_model.signals.values import MocapFrame


def test_ideal_sensing_passes_positions_through_and_finds_velocities():
    block = MocapFilter(IDEAL_SENSING, PAIR)
    for tick in range(300):
        state = block.update(frame_at(tick))
        pos, vel = truth_at(tick)
        assert np.array_equal(state.pos, pos)
        if tick >= 5:
            # the filter's lag on a jerk of 0.5 * 2 pi / 3 = 1 m/s^3; its gain on it is about 0.18 dt^2
            assert np.abs(state.vel - vel).max() < 4e-5


@given(st.floats(0.002, 0.05), st.floats(-3.0, 3.0))
@settings(max_examples=20, deadline=None)
def test_constant_velocity_is_found_at_any_rate(dt: float, speed: float):
    block = MocapFilter(replace(IDEAL_SENSING, clock_jump_s=100.0), ("cf1",))
    for tick in range(40):
        pos = np.array([[speed * tick * dt, 0.0, 1.0]])
        state = block.update(MocapFrame(tick * dt, ("cf1",), pos, identity_quat((1,))))
    # starting at rest is forgotten by the 40th sample
    assert np.allclose(state.vel, [[speed, 0.0, 0.0]], atol=1e-3)
    assert state.status[0] == TRACKED


def test_noise_of_vicon_gives_a_velocity_better_than_differences():
    rng = np.random.default_rng(3)
    block, errors, differences, before = MocapFilter(MocapFilterParams(), PAIR), [], [], truth_at(0)[0]
    for tick in range(400):
        measured = truth_at(tick)[0] + rng.normal(0.0, 1e-3, (2, 3))
        errors.append(block.update(frame_at(tick, measured)).vel - truth_at(tick)[1])
        differences.append((measured - before) / 0.01 - truth_at(tick)[1])
        before = measured
    rms, plain = (np.sqrt(np.mean(np.square(e[50:]))) for e in (errors, differences))
    assert rms < 0.05  # steady-state covariance of the filter: 0.034 m/s, with room for chance
    assert rms < 0.4 * plain


BEYOND_GATE_M = 0.075
"""Outliers that no gate lets pass after 50 ms: jump_max 0.04, 2 v tau of 0.03 at 0.3 m/s, a deviation."""


@given(st.integers(0, 2**32 - 1), st.floats(BEYOND_GATE_M, 10.0), st.integers(1, 5))
@settings(max_examples=25, deadline=None)
def test_a_burst_of_outliers_is_refused_and_bridged(seed: int, size: float, length: int):
    rng = np.random.default_rng(seed)
    block = flown_until(50)
    for tick in range(50, 50 + length):
        away = rng.standard_normal(3)
        pos, vel = truth_at(tick)
        measured = pos.copy()
        measured[0] += size * away / np.linalg.norm(away)
        state = block.update(frame_at(tick, measured))
        assert list(state.status) == [COASTING, TRACKED]
        assert np.allclose(state.age, [time_of(tick) - time_of(49), 0.0], atol=1e-9)
        # coasting 50 ms beside an acceleration estimate: jerk 1 m/s^3 * 0.05^3 / 6
        assert np.abs(state.pos - pos).max() < 1e-4
        assert np.abs(state.vel - vel).max() < 5e-3
    assert list(block.update(frame_at(50 + length)).status) == [TRACKED, TRACKED]
    assert block.report.refused == length


def test_a_true_jump_of_a_metre_is_accepted_within_a_tenth_of_a_second():
    block = flown_until(50)
    shift = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    accepted = [
        block.update(frame_at(tick, truth_at(tick)[0] + shift)).status[0] == TRACKED for tick in range(50, 80)
    ]
    first = accepted.index(True)
    assert first * 0.01 <= 0.1
    assert all(accepted[first:])
    assert block.report.restarted == 1
    assert np.array_equal(block.update(frame_at(80, truth_at(80)[0] + shift)).pos, truth_at(80)[0] + shift)


@pytest.mark.parametrize(("missing", "first"), [(2, 6), (4, 10)], ids=["30 ms of 60", "50 ms of 100"])
def test_a_jump_is_accepted_once_no_gap_is_longer_than_half_of_it(missing: int, first: int):
    block = flown_until(50)
    shift, accepted = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), []
    for tick in range(50, 70):
        pos = truth_at(tick)[0] + shift
        pos[0] = np.nan if 0 < tick - 50 <= missing else pos[0]
        accepted.append(block.update(frame_at(tick, pos)).status[0] == TRACKED)
    assert accepted.index(True) == first


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_no_gate_stays_closed_for_ever(seed: int):
    rng = np.random.default_rng(seed)
    block = MocapFilter(MocapFilterParams(), PAIR)
    for tick in range(60):  # anything at all
        wild = rng.normal(0.0, 10.0 ** rng.uniform(-3, 2), (2, 3))
        wild[rng.random((2, 3)) < 0.1] = np.nan
        block.update(frame_at(tick, wild, rng.normal(size=(2, 4))))
    states = [block.update(frame_at(tick)) for tick in range(60, 260)]
    for state in states[150:]:
        assert list(state.status) == [TRACKED, TRACKED]
        assert np.abs(state.pos - truth_at(round(state.t * 100))[0]).max() < 5e-3
        assert np.abs(np.abs(state.quat[:, 3]) - 1.0).max() < 1e-9


@pytest.mark.parametrize("size", [0.06, 0.12, 1.5])
def test_a_first_sample_is_not_trusted_and_an_outlier_as_first_is_gone_with_the_next(size: float):
    block = MocapFilter(MocapFilterParams(), PAIR)
    first = block.update(frame_at(0, truth_at(0)[0] + np.array([[size, 0.0, 0.0], [0.0, 0.0, 0.0]])))
    assert list(first.status) == [COASTING, COASTING]
    states = [block.update(frame_at(tick)) for tick in range(1, 6)]
    for tick, state in enumerate(states, start=1):
        assert np.abs(state.pos - truth_at(tick)[0]).max() < 5e-3  # five times the noise that is allowed for
        # 6 cm in a tick is a motion of 6 m/s: no vehicle's, so its speed is not taken over
        assert np.abs(state.vel).max() < 1.0
    assert [int(state.status[1]) for state in states] == [TRACKED] * 5
    assert [int(state.status[0]) for state in states[:2]] == [
        COASTING
    ] * 2  # one is refuted: two more must fit
    assert [int(state.status[0]) for state in states[2:]] == [TRACKED] * 3


def test_a_vehicle_missing_coasts_straight_then_is_lost_and_comes_back():
    block = flown_until(50)
    pos, vel = truth_at(49)
    for tick in range(50, 100):
        here = truth_at(tick)[0][1:]
        state = block.update(MocapFrame(time_of(tick), ("cf2",), here, identity_quat((1,))))
        gone = time_of(tick) - time_of(49)
        assert state.status[0] == (COASTING if gone <= COAST_S + 1e-9 else LOST)
        assert state.status[1] == TRACKED
        assert state.age[0] == pytest.approx(gone, abs=1e-9)
        if state.status[0] == COASTING:
            # straight ahead up to the acceleration accepted for 50 ms: 0.5 m/s^2 * 0.05 s over 0.35 s
            assert np.abs(state.pos[0] - pos[0] - vel[0] * gone).max() < 0.5 * 0.05 * COAST_S
        else:
            assert np.array_equal(state.vel[0], np.zeros(3))
    held = state.pos[0]
    assert np.array_equal(block.update(frame_at(100, np.full((2, 3), np.nan))).pos[0], held)
    back = [block.update(frame_at(tick)) for tick in range(101, 112)]
    assert np.array_equal(back[-1].pos, truth_at(111)[0])


def test_a_vehicle_never_seen_is_lost_with_documented_values():
    block = MocapFilter(IDEAL_SENSING, ("cf1", "cf2", "cf9"))
    block.update(frame_at(0))
    state = block.update(frame_at(1))
    assert list(state.status) == [TRACKED, TRACKED, LOST]
    assert np.array_equal(state.pos[2], np.zeros(3))
    assert np.array_equal(state.vel[2], np.zeros(3))
    assert np.array_equal(state.quat[2], [0, 0, 0, 1])
    assert np.isinf(state.age[2])


def test_samples_that_are_no_numbers_are_missing_samples():
    block = flown_until(50)
    for tick, value in enumerate((np.nan, np.inf, -np.inf, 1e308), start=50):
        pos = truth_at(tick)[0].copy()
        pos[0, 1] = value
        state = block.update(frame_at(tick, pos, np.array([[0, 0, 0, value], [0, 0, 0, 1.0]])))
        assert list(state.status) == [COASTING, TRACKED]
        assert np.isfinite(state.pos).all()
        assert np.isfinite(state.quat).all()


def test_a_vehicle_at_rest_without_noise_is_tracked():
    block = MocapFilter(MocapFilterParams(), PAIR)
    block.update(frame_at(0, truth_at(0)[0]))
    for tick in range(1, 50):
        assert list(block.update(frame_at(tick, truth_at(0)[0])).status) == [TRACKED, TRACKED]


def test_body_rate_comes_from_successive_attitudes():
    block = MocapFilter(IDEAL_SENSING, ("cf1",))
    for tick in range(20):
        quat = quat_from_euler(0.0, 0.0, 2.0 * time_of(tick))[None] * (-1.0) ** tick  # the sign means nothing
        state = block.update(MocapFrame(time_of(tick), ("cf1",), np.ones((1, 3)), quat))
        if tick:
            # successive quaternions over dt: rounding 1e-16 / 0.01 s
            assert np.allclose(state.ang_vel_body, [[0.0, 0.0, 2.0]], atol=1e-12)
    assert state.quat[0] @ quat_from_euler(0.0, 0.0, 2.0 * time_of(19)) == pytest.approx(1.0, abs=1e-12)


def test_an_axis_flip_of_a_reflection_is_refused_but_not_for_ever():
    block = flown_until(50)
    flipped = quat_multiply(identity_quat((2,)), quat_from_euler(0.0, np.pi, 0.0))
    for tick in range(50, 460):
        state = block.update(frame_at(tick, quat=flipped))
        lasted = time_of(tick) - time_of(50)
        expected = identity_quat((2,)) if lasted < IDEAL_SENSING.flip_reacquire_s - 1e-9 else flipped
        assert np.allclose(np.abs(np.sum(state.quat * expected, axis=-1)), 1.0, atol=1e-12)
        assert np.abs(state.ang_vel_body).max() < 1e-9
        assert list(state.status) == [TRACKED, TRACKED]
    assert block.report.attitudes_refused == 800


def test_an_axis_flip_is_refused_after_a_gap_that_would_allow_any_turn() -> None:
    block = MocapFilter(MocapFilterParams(), PAIR)
    flipped = np.tile(quat_from_euler(0.0, np.pi, 0.0), (2, 1))
    turned = np.tile(quat_from_euler(0.0, 0.0, 2.5), (2, 1))
    for tick in range(20):
        block.update(frame_at(tick))
    after = 20 + 33  # 0.33 s later, by a gap or by the clock
    np.testing.assert_allclose(block.update(frame_at(after, quat=flipped)).quat, identity_quat((2,)))
    np.testing.assert_allclose(block.update(frame_at(after + 1)).quat, identity_quat((2,)))
    np.testing.assert_allclose(
        block.update(frame_at(after + 34, quat=turned)).quat, turned
    )  # upright: accepted


def test_a_lone_marker_has_a_position_and_stays_level():
    block = MocapFilter(IDEAL_SENSING, PAIR)
    for tick in range(20):
        state = block.update(frame_at(tick, quat=np.full((2, 4), np.nan)))
    assert list(state.status) == [TRACKED, TRACKED]
    assert np.array_equal(state.quat, identity_quat((2,)))
    assert np.array_equal(state.ang_vel_body, np.zeros((2, 3)))


def test_vehicles_do_not_disturb_each_other():
    """A batch equals a loop: two vehicles in one filter, each in its own."""
    both = MocapFilter(MocapFilterParams(), PAIR)
    each = [MocapFilter(MocapFilterParams(), (name,)) for name in PAIR]
    rng = np.random.default_rng(8)
    for tick in range(200):
        pos = truth_at(tick)[0] + rng.normal(0.0, 1e-3, (2, 3))
        if tick % 17 == 0:
            pos[tick % 2] += 5.0
        state = both.update(frame_at(tick, pos))
        for row, single in enumerate(each):
            alone = single.update(
                MocapFrame(time_of(tick), (PAIR[row],), pos[row : row + 1], identity_quat((1,)))
            )
            assert alone.status[0] == state.status[row]
            assert np.array_equal(alone.pos[0], state.pos[row])
            assert np.array_equal(alone.vel[0], state.vel[row])


def test_bad_arguments_are_named():
    with pytest.raises(ValueError, match="cf1, cf1"):
        MocapFilter(IDEAL_SENSING, ("cf1", "cf1"))
    with pytest.raises(ValueError, match=r"speed_max = -1"):
        MocapFilterParams(speed_max=-1.0)
    with pytest.raises(ValueError, match=r"2 names, pos \(1, 3\)"):
        flown_until(1).update(MocapFrame(1.0, PAIR, np.zeros((1, 3)), np.zeros((2, 4))))


def test_an_attitude_counts_as_measured_from_its_first_sample_on_and_through_dropouts() -> None:
    block, turn = MocapFilter(IDEAL_SENSING, PAIR), quat_from_euler(0.01, -0.02, 0.3)
    lone = np.full((2, 4), np.nan)
    for tick in range(20):
        quat = lone.copy()
        if tick in {5, 6, 7, 15}:
            quat[1] = turn
        state = block.update(frame_at(tick, quat=quat))
        assert measured_attitudes(state).tolist() == [False, tick >= 5]
        np.testing.assert_array_equal(state.quat[0], identity_quat())
        np.testing.assert_array_equal(state.ang_vel_body[0], 0.0)
