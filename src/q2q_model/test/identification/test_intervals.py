"""Tests of intervals: 95 % of them contain the truth, under noise like that of real flights.

The push under a wake of real Crazyflies leaves 0.35 to 0.5 m/s^2 rms around the best law, correlated over
80 ms; here it is an Ornstein-Uhlenbeck process on flights with a known jet.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter
from threadpoolctl import threadpool_limits

from q2q_model.downwash.jet import Jet
from q2q_model.identification.jet.jet_fit import fit_to_pushes
from q2q_model.identification.jet.jet_form import JetForm
from q2q_model.identification.push.along_flight import Motion, eta_along
from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.identification.statistics.intervals import (
    UNKNOWN,
    EstimatingRows,
    Stretch,
    cluster_rows,
    correlation_time,
    half_widths,
    intervals,
    least_squares_rows,
    variances,
)
from q2q_model.signals.values import Array

FORM = JetForm("exponential", carried=0.0, delayed=True)
TRUTH = {
    "strength": 2.5,
    "decay_rate": 1.0,
    "width": 0.05,
    "spread": 0.05,
    "upper_ratio": 0.02,
    "slowness": 0.15,
}
TAU, TICK = 0.08, 0.04
"""Correlation time of the noise, and time between samples [s]."""
FITS = 300


def wander(rng: np.random.Generator, ticks: int, rms: float) -> Array:
    """Return an Ornstein-Uhlenbeck process, stationary from its start, (ticks,)."""
    keep = np.exp(-TICK / TAU)
    steps = rms * np.sqrt(1.0 - keep**2) * rng.standard_normal(ticks)
    steps[0] /= np.sqrt(1.0 - keep**2)
    return np.asarray(lfilter([1.0], [1.0, -keep], steps))


@cache
def flight() -> list[tuple[PushSamples, Array]]:
    """Return a flight in which one passes to and fro over a hovering one, and the push on either."""
    t = TICK * np.arange(1600)
    phase, gap = 2.0 * np.pi * t / 4.0, np.interp(t, [0.0, 32.0, 64.0], [0.25, 0.7, 0.25])
    pos, vel = np.zeros((2, t.size, 2, 3))
    pos[:, 1] = np.stack([0.6 * np.sin(phase), 0.03 * np.sin(0.8 * phase), gap], axis=1)
    vel[:, 1] = np.gradient(pos[:, 1], TICK, axis=0)
    motion = Motion(t, pos, vel, np.tile([0.0, 0.0, 1.0], (t.size, 2, 1)))
    jet = {name: value for name, value in TRUTH.items() if name != "slowness"}
    law = Jet(reference_gap=0.4, decay="exponential", travel_speed=1.0 / TRUTH["slowness"], range=1.5, **jet)
    eta, near = eta_along(law, motion)[..., 2], np.hypot(pos[:, 1, 0], pos[:, 1, 1])
    none = np.zeros(t.size, dtype=np.bool_)
    lower = PushSamples("passes", motion, 0, t, ~none, near < 0.15, none)
    return [(lower, eta[:, 0]), (replace(lower, vehicle=1, exposed=none, upper=near < 0.1), eta[:, 1])]


def noisy(rng: np.random.Generator) -> list[PushSamples]:
    """Return what the flight showed this time."""
    rms = rng.uniform(0.35, 0.5)
    return [replace(one, y=eta + wander(rng, eta.size, rms)) for one, eta in flight()]


def test_a_jets_intervals_hold_the_truth_as_often_as_they_say():
    """One flight, whose clusters are stretches of time."""
    rng, held = np.random.default_rng(13), dict.fromkeys(TRUTH, 0)
    with threadpool_limits(1, user_api="blas"):
        for _ in range(FITS):
            found = dict(fit_to_pushes(noisy(rng), FORM).intervals)
            for name, value in TRUTH.items():
                held[name] += found[name].low <= value <= found[name].high
    assert all(0.90 * FITS <= count <= 0.98 * FITS for count in held.values()), held


def test_intervals_by_flight_hold_the_truth_as_often_as_they_say():
    """A line through 16 flights, each with an error of its own, which no stretch of time would show."""
    rng, held = np.random.default_rng(5), np.zeros(2)
    fits, flights, truth = 400, np.repeat(np.arange(16), 50), np.array([1.0, -0.5])
    for _ in range(fits):
        across = rng.standard_normal(16)[flights] + rng.standard_normal(flights.size)
        columns = np.stack([np.ones_like(across), across], axis=1)
        y = columns @ truth + 0.5 * rng.standard_normal(16)[flights] + rng.standard_normal(flights.size)
        value = np.linalg.lstsq(columns, y)[0]
        stretches = [Stretch(k, np.arange(50.0), (y - columns @ value)[flights == k]) for k in range(16)]
        cluster = cluster_rows(stretches, 1.0)
        found = intervals(value, least_squares_rows(columns, y - columns @ value, cluster))
        held += [one.low <= true <= one.high for one, true in zip(found, truth, strict=True)]
    assert np.all((held >= 0.92 * fits) & (held <= 0.98 * fits)), held  # 2.7 deviations of a count below


def test_the_variance_is_right_on_average_where_clusters_are_few_and_uneven():
    rng, cluster = np.random.default_rng(6), np.repeat(np.arange(5.0), [30, 4, 4, 4, 2])
    columns = rng.standard_normal((44, 2))
    solve, found = np.linalg.pinv(columns), []
    for _ in range(2000):
        y = rng.standard_normal(44)
        found.append(variances(least_squares_rows(columns, y - columns @ (solve @ y), cluster))[0])
    true = np.diag(np.linalg.inv(columns.T @ columns))
    np.testing.assert_allclose(np.mean(found, axis=0), true, rtol=0.08)  # 3 deviations of the mean


def test_a_parameter_that_nothing_or_one_cluster_alone_shows_has_an_endless_interval():
    rng, cluster = np.random.default_rng(7), np.repeat(np.arange(10.0), 5)
    seen, unseen, once = rng.standard_normal(50), np.zeros(50), np.where(cluster == 3.0, 1.0, 0.0)
    columns = np.stack([seen, unseen, once], axis=1)
    wide = half_widths(least_squares_rows(columns, 0.1 * rng.standard_normal(50), cluster))
    assert wide[0] < 0.1
    assert wide[1] == UNKNOWN
    assert wide[2] > 1e3


def test_the_correlation_time_is_that_of_the_noise_and_stretches_are_ten_times_longer():
    rng = np.random.default_rng(8)
    t = TICK * np.arange(5000)
    seen = np.ones(t.size, dtype=bool)
    seen[1250:1750] = False  # a hole
    one = Stretch(0, t[seen], wander(rng, t.size, 1.0)[seen])
    assert correlation_time([one]) == pytest.approx(0.9 * TAU, rel=0.1)  # cut where a tenth is left
    assert np.unique(cluster_rows([one], 0.1)).size == pytest.approx(180.0 / (9.0 * TAU), rel=0.15)
    nothing = Stretch(1, np.empty(0), np.empty(0))
    assert np.unique(cluster_rows([one, nothing], 10.0)).size == 16  # of 49.96 s and 129.96 s


def test_hubers_gains_keep_their_claim_with_rows_that_weigh_less():
    """Psi' is 0 where a row is cut: the location of a normal sample, cut at 1.345, by the textbook."""
    rng, cut, n = np.random.default_rng(9), 1.345, 20_000
    r = rng.standard_normal(n)
    psi = np.clip(r, -cut, cut)
    slope = (np.abs(r) < cut).astype(np.float64)
    wide = half_widths(EstimatingRows(np.ones((n, 1)), psi, slope, np.arange(float(n))))
    assert wide[0] == pytest.approx(1.96 * np.sqrt((psi**2).mean() / n) / slope.mean(), rel=1e-3)
