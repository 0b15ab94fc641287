"""Steps of references: no rate is read from a fit that reaches over one, and no other is lost."""

import numpy as np
import pytest

from q2q_model.flights.sampled_reference import HOLD_S, WIDTH, sampled_reference
from q2q_model.signals.values import Array

T = np.arange(2000) * 0.01
OMEGA = 2.0 * np.pi * 0.5
UNKNOWN = np.full((len(T), 1, 3), np.nan)


def sine(t: Array) -> tuple[Array, Array]:
    """Return position and acceleration of one vehicle at times t, (k, 1, 3) each."""
    phase = OMEGA * t[:, None, None] + np.array([0.0, 1.0, 2.0])
    return 0.2 * np.sin(phase), -0.2 * OMEGA**2 * np.sin(phase)


def test_a_step_has_no_rates_and_a_goal_stands() -> None:
    pos = np.where(T[:, None, None] < 10.0, [0.0, 0.0, 1.0], [0.0, 0.0, 1.5])
    found = sampled_reference(T, pos, UNKNOWN, UNKNOWN)
    near = np.abs(T - 9.995) < 0.1
    assert not found.sure[near].any()
    assert found.sure[np.abs(T - 9.995) > HOLD_S].all()
    np.testing.assert_allclose(found.vel[np.abs(T - 9.995) > HOLD_S], 0.0, atol=1e-9)


def test_no_rate_of_a_fit_that_reaches_over_a_step_is_sure() -> None:
    """A step of 0.2 m at the end of a cubic bends it by 10 m/s^2, and it misses little."""
    smooth, acc = sine(T)
    pos = smooth + 0.2 * (T[:, None, None] > 10.0)
    found = sampled_reference(T, pos, UNKNOWN, UNKNOWN)
    sure = found.sure[:, 0] & (np.abs(T - 10.0) < 9.5)
    np.testing.assert_allclose(found.acc[sure], acc[sure], atol=4e-2 * 0.2 * OMEGA**2)
    assert found.sure[np.abs(T - 10.0) > 2.2 * WIDTH].all()


@pytest.mark.parametrize("size", [0.02, 0.05, 0.2])
@pytest.mark.parametrize("every", [1, 5, 10])
def test_small_steps_of_a_moving_reference_are_found(size: float, every: int) -> None:
    """One of 2 cm bends a cubic by 1 m/s^2, which misses it by less than a tenth of its extent."""
    smooth, acc = sine(T)
    steps = np.arange(2.0, 19.0, 2.5)
    held = np.arange(len(T)) // every * every
    pos = (smooth + size * np.searchsorted(steps, T + 1e-9, side="right")[:, None, None])[held]
    found = sampled_reference(T, pos, UNKNOWN, UNKNOWN)
    inner = (np.abs(T - 10.0) < 9.0) & (held == np.arange(len(T)))
    sure = inner & found.sure[:, 0]
    np.testing.assert_allclose(found.acc[sure], acc[sure], atol=4e-2 * 0.2 * OMEGA**2)
    away = np.abs(T[:, None] - steps).min(axis=1) > 2.2 * WIDTH + 0.1 * (every == 10)
    assert found.sure[inner & away].all()


@pytest.mark.parametrize("period", [0.4, 0.5, 0.6])
def test_goals_that_stand_for_longer_than_a_fit_have_rates_of_zero_between(period: float) -> None:
    goals = np.random.default_rng(2).uniform(-0.2, 0.2, (60, 1, 3))
    found = sampled_reference(T, goals[np.floor(T / period + 1e-9).astype(int)], UNKNOWN, UNKNOWN)
    assert found.sure.mean() > 0.95 - 2.0 * (WIDTH + 0.01) / period
    np.testing.assert_allclose(found.acc[found.sure], 0.0, atol=1e-8)


def test_a_sample_with_too_few_around_takes_no_rates_from_others() -> None:
    given, acc = sine(T)
    pos = given.copy()
    pos[(np.abs(T - 10.0) < 0.145) & (np.abs(T - 10.0) > 0.005)] = np.nan
    found = sampled_reference(T, pos, UNKNOWN, UNKNOWN)
    assert not found.sure[1000]
    near = (np.abs(T - 10.0) > 0.145) & (np.abs(T - 10.0) < 1.0)
    assert found.sure[near].all()
    np.testing.assert_allclose(found.acc[near], acc[near], atol=0.2 * 0.2 * OMEGA**2)  # a side is lost


@pytest.mark.parametrize("every", [1, 2, 5, 10])
@pytest.mark.parametrize("late", [0.0, 3e-3])
def test_rounding_and_late_stamps_are_no_steps(every: int, late: float) -> None:
    smooth = 5.0 * sine(T)[0]
    held = np.arange(len(T)) // every * every
    t = T + np.random.default_rng(6).uniform(-late, late, len(T))
    for pos in (smooth, smooth.astype(np.float32).astype(np.float64), smooth.round(3)):
        found = sampled_reference(t, pos[held], UNKNOWN, UNKNOWN)
        assert found.sure[50:-50:every].all()  # at the ends of 10 Hz are too few


@pytest.mark.parametrize("scale", [0.1, 0.3])
def test_slow_references_in_whole_millimetres_have_no_steps(scale: float) -> None:
    pos = (scale * sine(T)[0]).round(3)
    found = sampled_reference(T, pos, UNKNOWN, UNKNOWN)
    assert found.sure[np.isfinite(found.pos).all(axis=2)].mean() > 0.95


def test_ticks_in_bursts_have_rates() -> None:
    """Ten within 5 ms count as one sample in a fit."""
    t = (0.1 * np.arange(200)[:, None] + 5e-4 * np.arange(10)).ravel()
    pos, acc = sine(t)
    found = sampled_reference(t, pos, UNKNOWN, UNKNOWN)
    inner = (t > 0.5) & (t < 19.5)
    assert found.sure[inner].all()
    np.testing.assert_allclose(found.acc[inner], acc[inner], atol=5e-2 * 0.2 * OMEGA**2)
