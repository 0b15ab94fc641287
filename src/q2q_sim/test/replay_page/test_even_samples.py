"""Samples on an even grid: between ticks interpolated, at gaps missing."""

import numpy as np
import pytest

from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import Array
from q2q_sim.replay_page.even_samples import HOLE_S, even_quats, even_samples, even_times

ACC, TURN = 3.0, 1.5
"""Acceleration [m/s^2] and turn rate [rad/s] of the curve."""


def circle(t: Array) -> Array:
    """Return positions (T, 1, 2) on a circle that is flown at ACC and TURN."""
    return ACC / TURN**2 * np.stack([np.sin(TURN * t), np.cos(TURN * t)], axis=1)[:, None]


def jittered() -> Array:
    """Return stamps at 100 Hz, off by up to 3 ms, of a clock that counts from 1970."""
    return 1.79e9 + 0.01 * np.arange(1000) + np.random.default_rng(0).uniform(-0.003, 0.003, 1000)


@pytest.mark.parametrize("t", [np.arange(600) / hz for hz in (60.0, 120.0, 240.0)] + [jittered()])
def test_between_ticks_samples_are_off_by_no_more_than_a_chord_of_the_curve(t: Array) -> None:
    at = even_times(t, 50.0)
    off = np.linalg.norm(even_samples(t, circle(t - t[0]), at) - circle(at - t[0]), axis=-1)
    assert off.max() <= ACC * np.diff(t).max() ** 2 / 8.0 + 1e-6  # stamps of 1.79e9 s round to 0.24 us


def test_a_tick_without_a_value_is_missing_and_its_neighbours_are_not() -> None:
    t = 0.02 * np.arange(50)
    values = circle(t)
    values[20:25, 0, 1] = np.nan
    samples = even_samples(t, values, t)
    np.testing.assert_array_equal(samples, values)
    later = even_samples(t, values, t + 0.004)  # the nearest tick is the one before
    np.testing.assert_array_equal(np.isfinite(later), np.isfinite(values))


def test_no_sample_is_further_than_the_bound_from_a_tick() -> None:
    t = np.concatenate([0.01 * np.arange(100), 5.0 + 0.01 * np.arange(100)])
    at = even_times(t, 50.0)
    away = np.abs(at[:, None] - t).min(axis=1)
    known = np.isfinite(even_samples(t, circle(t), at)).all(axis=(1, 2))
    np.testing.assert_array_equal(known, away <= HOLE_S)
    assert not known.all()


@pytest.mark.parametrize("gap", [0, 3])
def test_a_turn_over_the_top_is_interpolated_the_short_way_whatever_the_signs(gap: int) -> None:
    t = np.arange(240) / 60.0
    quat = quat_from_euler(TURN * t, 0.0 * t, 0.3 + 0.0 * t)[:, None]  # w passes 0 at roll pi
    quat *= np.random.default_rng(1).choice([-1.0, 1.0], (240, 1, 1))
    quat[100 : 100 + gap] = np.nan
    at = even_times(t, 50.0)
    found = even_quats(t, quat, at)
    there = np.isfinite(found).all(axis=(1, 2))
    assert there.sum() >= len(at) - gap
    assert there.all() == (gap == 0)
    assert found[there, 0, 3].min() >= 0.0
    true = quat_from_euler(TURN * at, 0.0 * at, 0.3 + 0.0 * at)
    alike = np.abs((found[there, 0] * true[there]).sum(axis=1))
    assert 2.0 * np.arccos(np.clip(alike, 0.0, 1.0)).max() < 1e-5  # [rad], of 0.025 from tick to tick
