"""Tests of what frames show: noise as large as said, every fault marked, every stream on its own."""

from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_state

from q2q_model.geometry.rotations import quat_conjugate, quat_from_euler, quat_multiply, vector_from_quat
from q2q_model.signals.values import MocapFrame, SwarmState
from q2q_sim.scenarios.room_profiles import ROUGH
from q2q_sim.sensors.episodes import AHEAD, Episodes, Frequency
from q2q_sim.sensors.vicon import Injected, Vicon
from q2q_sim.sensors.vicon_params import ViconParams

TICK = 0.01
PERFECT = ViconParams()


def _truth(k: int, n: int = 4) -> SwarmState:
    pos = np.array([[0.5 * i, 0.01 * k, 1.0 + 0.1 * i] for i in range(n)])
    return resting_state(
        k * TICK,
        tuple(f"cf{i + 1}" for i in range(n)),
        pos,
        quat=quat_from_euler(np.full(n, 0.1), np.full(n, -0.05), np.full(n, 0.3)),
    )


def _watch(params: ViconParams, ticks: int, seed: int = 1, n: int = 4) -> tuple[list[MocapFrame], np.ndarray]:
    vicon = Vicon(params, n, TICK, seed)
    frames, flags = [], []
    for k in range(ticks):
        frames.append(vicon.observe(_truth(k, n)))
        flags.append(vicon.injected)
    return frames, np.array(flags)


def test_perfect_eyes_see_the_truth() -> None:
    frames, flags = _watch(PERFECT, 10)
    for k, frame in enumerate(frames):
        np.testing.assert_array_equal(frame.pos, _truth(k).pos)
        np.testing.assert_array_equal(frame.quat, _truth(k).quat)
    assert not flags.any()


def test_noise_is_as_large_as_said_and_without_bias() -> None:
    frames, _ = _watch(ViconParams(pos_noise=0.00015, angle_noise=0.003), 1000)
    error = np.array([frame.pos - _truth(k).pos for k, frame in enumerate(frames)])
    turn = np.array(
        [vector_from_quat(_relative(frame.quat, _truth(k).quat)) for k, frame in enumerate(frames)]
    )
    for sample, std in ((error, 0.00015), (turn, 0.003)):
        n = sample.size
        assert sample.std() == pytest.approx(std, rel=4.0 / np.sqrt(2.0 * n))  # 4 sigma of a deviation
        assert abs(sample.mean()) < 4.0 * std / np.sqrt(n)


def _relative(quat: np.ndarray, to: np.ndarray) -> np.ndarray:
    return quat_multiply(quat_conjugate(to), quat)


def test_every_row_that_is_off_is_marked_and_no_other() -> None:
    params = replace(
        ROUGH.vicon, pos_noise=0.0, angle_noise=0.0, outlier_rate=2.0, swap_rate=0.5, flip_rate=0.5
    )
    frames, flags = _watch(params, 3000)
    for k, frame in enumerate(frames):
        truth = _truth(k)
        for i, name in enumerate(truth.names):
            if name not in frame.names:
                assert flags[k, i] & Injected.DROPOUT
                continue
            row = frame.names.index(name)
            true = np.array_equal(frame.pos[row], truth.pos[i]) and np.array_equal(
                frame.quat[row], truth.quat[i]
            )
            assert true == (flags[k, i] == Injected.NOTHING)
    for what in (Injected.OUTLIER, Injected.FLIP, Injected.SWAP, Injected.DROPOUT, Injected.STALE):
        assert (flags & what).any()


def test_outliers_are_as_frequent_and_as_large_as_said() -> None:
    params = ViconParams(outlier_rate=5.0, outlier_min=0.3, outlier_max=0.9)
    frames, flags = _watch(params, 5000)
    away = np.array([np.linalg.norm(frame.pos - _truth(k).pos, axis=1) for k, frame in enumerate(frames)])
    struck = (flags & Injected.OUTLIER) > 0
    assert away[struck].min() >= 0.3
    assert away[struck].max() <= 0.9
    expected = 5.0 * 5000 * TICK * 4
    assert struck.sum() == pytest.approx(
        expected, abs=4.0 * np.sqrt(expected) + 0.03 * expected
    )  # rate exp(-.05)


def test_dropouts_last_as_long_as_said() -> None:
    _, flags = _watch(ViconParams(dropout_rate=0.5, dropout_min=0.1, dropout_max=0.3), 6000)
    lengths = []
    for column in flags.T:
        edges = np.flatnonzero(np.diff(np.concatenate([[0], column > 0, [0]])))
        lengths += list((edges[1::2] - edges[::2])[:-1])  # the last may be cut off by the end
    assert len(lengths) > 20
    # two may touch, where one begins in the tick after another ends: rare at 0.5 a second
    assert min(lengths) >= 10
    assert np.median(lengths) == pytest.approx(20, abs=4)


def test_a_swap_exchanges_two_neighbours() -> None:
    frames, flags = _watch(ViconParams(swap_rate=1.0, swap_max=0.1), 1000)
    swapped = [k for k in range(1000) if (flags[k] & Injected.SWAP).sum() == 2 * Injected.SWAP]
    assert swapped
    for k in swapped:
        i, j = np.flatnonzero(flags[k])
        assert j - i == 1  # the nearest: vehicles stand in a row
        np.testing.assert_array_equal(frames[k].pos[[i, j]], _truth(k).pos[[j, i]])


def test_a_flip_turns_the_body_by_half_a_turn_about_one_of_its_axes() -> None:
    frames, flags = _watch(ViconParams(flip_rate=1.0, flip_max=0.05), 1000)
    axes = set()
    for k, frame in enumerate(frames):
        for i in np.flatnonzero(flags[k] & Injected.FLIP):
            turn = np.abs(_relative(frame.quat[i], _truth(k).quat[i]))
            axes.add(int(np.argmax(turn)))
            np.testing.assert_allclose(np.sort(turn), [0.0, 0.0, 0.0, 1.0], atol=1e-12)
    assert axes == {0, 1, 2}


def test_switching_one_fault_off_leaves_the_others_where_they_were() -> None:
    params = ROUGH.vicon
    _, all_on = _watch(params, 3000, seed=7)
    _, no_drops = _watch(replace(params, dropout_rate=0.0, missing_rate=0.0, pos_noise=0.0), 3000, seed=7)
    others = 0xFF & ~int(Injected.DROPOUT)
    np.testing.assert_array_equal(all_on & others, no_drops & others)
    assert (all_on & Injected.DROPOUT).any()
    assert not (no_drops & Injected.DROPOUT).any()


def test_seeds_differ_and_repeat() -> None:
    first, again, other = (_watch(ROUGH.vicon, 50, seed=seed)[0] for seed in (3, 3, 4))
    for a, b in zip(first, again, strict=True):
        np.testing.assert_array_equal(a.pos, b.pos)
    assert any(
        a.pos.shape != b.pos.shape or not np.array_equal(a.pos, b.pos)
        for a, b in zip(first, other, strict=True)
    )


def test_bounds_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"ViconParams.pos_noise = -0.1; must be in \[0.0, 0.1\] m"):
        ViconParams(pos_noise=-0.1)
    with pytest.raises(ValueError, match=r"dropout_min = 0.5 is above dropout_max = 0.3"):
        ViconParams(dropout_min=0.5)


def test_no_swap_begins_in_the_first_frame_which_says_which_vehicle_is_which() -> None:
    always = ViconParams(swap_rate=10.0, swap_max=0.1)
    begun = [_watch(always, 3, seed=seed)[1] for seed in range(300)]
    assert not any((flags[0] & Injected.SWAP).any() for flags in begun)
    later = sum(bool((flags[1] & Injected.SWAP).any()) for flags in begun)
    assert later > 30  # of 300, each of four vehicles by 1 - exp(-0.1)


def test_one_vehicle_alone_cannot_be_swapped() -> None:
    _, flags = _watch(ViconParams(swap_rate=5.0), 100, n=1)
    assert not flags.any()


def test_episodes_drawn_ahead_are_those_drawn_one_tick_at_a_time() -> None:
    often, rows, ticks = Frequency(3.0, 0.02, 0.1), 3, 5 * AHEAD + 1
    ahead, rng = Episodes(often, rows, TICK, np.random.default_rng(4)), np.random.default_rng(4)
    left, chance, begun = np.zeros(rows, dtype=int), 1.0 - np.exp(-3.0 * TICK), 0
    for _ in range(ticks):
        draws = rng.random((2, rows))
        left = np.maximum(left - 1, 0)
        begins = (left == 0) & (draws[0] < chance)
        left[begins] = np.maximum(np.rint((0.02 + 0.08 * draws[1, begins]) / TICK), 1)
        begun += int(begins.sum())
        happening = ahead.step()
        acting, starting = (left > 0, begins) if happening is None else happening
        assert (happening is None) == (not (left > 0).any())
        np.testing.assert_array_equal(acting, left > 0)
        np.testing.assert_array_equal(starting, begins)
    assert begun > rows
