"""The growth of downwash with its source's thrust is found where it is, and 0 where it is not."""

import numpy as np
import pytest
from scipy.signal import lfilter

from q2q_model.downwash.jet import Jet
from q2q_model.identification.jet.loading import MOST, loading_of, usable_loading
from q2q_model.identification.push.along_flight import Motion, eta_along
from q2q_model.identification.push.push_samples import PushRecord, PushSamples, push_samples
from q2q_model.identification.statistics.intervals import Interval
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

LAW = Jet(strength=2.5, reference_gap=0.4, decay="exponential", decay_rate=1.0, width=0.05, spread=0.05,
          upper_ratio=0.0, travel_speed=0.0, carried=0.0, range=1.5)  # fmt: skip
TICK, TAU, RMS = 0.02, 0.08, 0.4
"""Samples [s]; noise of the push under a wake: its correlation time [s] and deviation [m/s^2]."""


def motion(vehicles: int = 3, seconds: float = 120.0) -> Motion:
    """Return a top vehicle that passes to and fro over two others, the middle one over the lowest."""
    t = TICK * np.arange(round(seconds / TICK))
    pos = np.zeros((t.size, vehicles, 3))
    pos[:, :, 2] = np.array([0.9, 1.2, 1.5])[:vehicles]
    for k, period in enumerate((7.0, 4.6)[: vehicles - 1]):
        pos[:, k + 1, 0] = 0.4 * np.sin(2.0 * np.pi * t / period)
    vel = np.gradient(pos, TICK, axis=0)
    return Motion(t, pos, vel, np.tile([0.0, 0.0, 1.0], (t.size, vehicles, 1)))


def push(moved: Motion, loading: float) -> Array:
    """Return the pushes in an air of a known loading, (T, n): each pair by hand, from the top down."""
    ticks, n = moved.pos.shape[:2]
    felt = np.zeros((ticks, n))
    for i in reversed(range(n)):
        for j in range(i + 1, n):
            two = Motion(moved.t, *(values[:, [i, j]] for values in (moved.pos, moved.vel, moved.axis)))
            felt[:, i] += eta_along(LAW, two)[:, 0, 2] * (1.0 - loading * felt[:, j] / GRAVITY)
    return felt


def flown(moved: Motion, pushes: Array, rng: np.random.Generator, rms: float = RMS) -> list[PushSamples]:
    """Return what sensors show of pushes in turbulent air."""
    keep = np.exp(-TICK / TAU)
    steps = rms * np.sqrt(1.0 - keep**2) * rng.standard_normal(pushes.shape)
    good = np.ones(pushes.shape, dtype=bool)
    noise = lfilter([1.0], [1.0, -keep], steps, axis=0)
    names = ("low", "mid", "top")[: pushes.shape[1]]
    return push_samples(PushRecord("stack", names, moved, pushes + noise, good, ~good))


@pytest.mark.parametrize("truth", [0.0, 1.0])
def test_the_loading_of_a_stack_is_found_and_is_zero_where_there_is_none(truth: float):
    rng, moved, flights = np.random.default_rng(21), motion(), 40
    pushes = push(moved, truth)
    found = [loading_of(LAW, flown(moved, pushes, rng)) for _ in range(flights)]
    known = [one for one in found if one is not None]
    assert len(known) == flights
    assert sum(one.low <= truth <= one.high for one in known) >= 0.85 * flights  # 95 %: 2.9 deviations below
    used = [usable_loading(one) for one in known]
    if truth == 0.0:
        assert np.count_nonzero(used) <= 0.10 * flights  # 2.5 % expected
    else:
        assert min(used) > 0.0
        assert np.mean(used) == pytest.approx(truth, abs=0.1)


def test_a_law_of_the_wrong_strength_is_not_taken_for_loading():
    moved = motion()
    weak = 0.7 * push(moved, 0.0)
    found = loading_of(LAW, flown(moved, weak, np.random.default_rng(22), rms=0.01))
    assert found is not None
    assert found.value == pytest.approx(0.0, abs=0.02)


def test_a_pair_shows_no_loading():
    moved = motion(vehicles=2)
    assert loading_of(LAW, flown(moved, push(moved, 1.0), np.random.default_rng(23))) is None


def test_a_loading_that_may_be_zero_is_zero_and_none_is_more_than_a_controller_takes():
    assert usable_loading(None) == 0.0
    assert usable_loading(Interval(1.5, -0.1, 3.1)) == 0.0
    assert usable_loading(Interval(-1.0, -1.5, -0.5)) == 0.0
    assert usable_loading(Interval(0.8, 0.5, 1.1)) == 0.8
    assert usable_loading(Interval(5.0, 4.0, 6.0)) == MOST
