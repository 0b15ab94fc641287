"""Ticks of a flight are those of its truth, and those of its frames where the truth is lost."""

import numpy as np
import pytest

from q2q_model.flights.flight_ticks import flight_ticks
from q2q_model.signals.values import Array

TICKS = np.linspace(0.0, 9.99, 1000)


def lost(begin: float, end: float) -> Array:
    """Return the ticks without those from begin to before end [s]."""
    return TICKS[(begin - 0.005 > TICKS) | (end - 0.005 < TICKS)]


@pytest.mark.parametrize(("begin", "end"), [(0.0, 4.0), (5.55, 9.5), (5.0, 10.0), (0.01, 10.0), (3.0, 3.01)])
def test_no_tick_is_lost_with_its_truth(begin: float, end: float) -> None:
    np.testing.assert_array_equal(flight_ticks(lost(begin, end), TICKS), TICKS)


def test_scattered_losses_of_truth_are_no_ticks_lost() -> None:
    kept = TICKS[np.random.default_rng(1).random(1000) > 0.3]
    np.testing.assert_array_equal(flight_ticks(kept, TICKS), TICKS)


@pytest.mark.parametrize("jump", [-0.4, -0.004, 0.004, 0.4, 100.0])
def test_a_clock_that_jumps_makes_no_ticks(jump: float) -> None:
    frames = TICKS + jump * (TICKS > 5.0)
    np.testing.assert_array_equal(flight_ticks(TICKS, frames), TICKS)
    np.testing.assert_array_equal(flight_ticks(lost(2.0, 3.0), frames), TICKS)


def test_a_frame_that_is_sent_again_under_a_clock_that_jumped_makes_no_tick() -> None:
    frames = TICKS + 100.0 * (TICKS > 5.0)
    np.testing.assert_array_equal(flight_ticks(TICKS, np.append(frames[:20], frames[19:])), TICKS)


def test_truth_of_another_rate_makes_no_ticks() -> None:
    for truth in (TICKS[::5], np.linspace(0.0, 9.995, 2000), np.linspace(0.0, 9.998, 5000), TICKS[:1]):
        np.testing.assert_array_equal(flight_ticks(truth, TICKS), TICKS)


def test_frames_of_one_stamp_are_no_ticks() -> None:
    np.testing.assert_array_equal(flight_ticks(TICKS, np.full(1000, 3.0)), TICKS)
