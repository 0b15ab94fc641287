"""Flights recorded below 100 Hz, or with lost rows, teach the air of the room that they were flown in."""

from dataclasses import fields, replace

import numpy as np
import pytest
from known_air import RESIDUAL, SECONDS, assert_within
from synthetic_air import DT, Wake, flown, orbit, process, still_record, wide_jet, with_push

from q2q_model.signals.values import Rows
from q2q_sim.air.air_terms import ResidualTerm
from q2q_sim.air.learning.jet.leave_one_group_out import HeldOutGroup
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.residual.residual_term import residual_term
from q2q_sim.air.learning.residual.wake_residuals import LAGS, wake_residuals
from q2q_sim.air.learning.statistics.autocovariance import flight_lags, lagged_pairs
from q2q_sim.air.learning.wind_term import wind_term


def kept(record: AirRecord, rows: Rows) -> AirRecord:
    """Return some rows of a record."""
    motion = replace(
        record.motion, **{one.name: getattr(record.motion, one.name)[rows] for one in fields(record.motion)}
    )
    arrays = {
        one.name: values[rows]
        for one in fields(record)
        if isinstance(values := getattr(record, one.name), np.ndarray)
    }
    thin = replace(record, motion=motion, **arrays)
    return with_push(thin, np.stack([one.y[rows] for one in record.samples], axis=1))


def every(record: AirRecord, step: int) -> AirRecord:
    """Return every `step`-th row of a record."""
    return kept(record, np.arange(0, record.motion.t.size, step))


def lossy(record: AirRecord, seed: int) -> AirRecord:
    """Return a record that lost 30 % of its rows."""
    return kept(record, np.flatnonzero(np.random.default_rng(seed).random(record.motion.t.size) >= 0.3))


@pytest.fixture(scope="module")
def pairs() -> list[AirRecord]:
    """Return two flights of a pair in a known jet and residual, at 100 Hz."""
    return [
        flown(f"pair{k}", orbit(SECONDS, (0.6, 1.05), k), Wake(wide_jet(), None, RESIDUAL), k) for k in (0, 1)
    ]


def test_lags_are_whole_ticks_and_told_at_their_own_times() -> None:
    fast = flight_lags(np.arange(0.0, 10.0, 0.01), LAGS)
    np.testing.assert_array_equal(fast.times, LAGS)  # to the last bit
    np.testing.assert_array_equal(fast.ticks, [0, 1, 2, 3, 5, 8, 12, 16, 20])
    slow = flight_lags(np.arange(0.0, 10.0, 0.05), LAGS)
    np.testing.assert_array_equal(slow.ticks, [0, 1, 2, 3, 4])
    np.testing.assert_array_equal(slow.times, [0.0, 0.05, 0.1, 0.15, 0.2])
    assert flight_lags(np.arange(0.0, 10.0, 0.2), np.array([0.05])).ticks.tolist() == [1]  # never a variance


@pytest.mark.parametrize("steps", [(2, 2), (5, 5), (1, 2)])
def test_the_residual_of_slow_flights_is_that_of_fast_ones(
    pairs: list[AirRecord], steps: tuple[int, int]
) -> None:
    thin = tuple(every(record, step) for record, step in zip(pairs, steps, strict=True))
    found = residual_term([HeldOutGroup(thin, wide_jet())], None)
    assert found is not None
    assert_within(found.values, "residual.time_s", RESIDUAL.time_s)
    assert found.term.time_s == pytest.approx(RESIDUAL.time_s, rel=0.2)  # 50 Hz at wrong lags: -40 %
    whole = residual_term([HeldOutGroup(tuple(pairs), wide_jet())], None)
    assert whole is not None
    level = [_at(one.term, 1.5) for one in (found, whole)]
    assert level[0] == pytest.approx(level[1], rel=0.1)  # a fifth of the rows


def _at(term: ResidualTerm, eta: float) -> float:
    """Return the standard deviation of a residual at a mean downwash [m/s^2]."""
    return term.floor_mps2 + term.slope * eta


def test_a_flight_without_clear_air_takes_that_of_others_at_its_own_lags(pairs: list[AirRecord]) -> None:
    dark = replace(every(pairs[1], 5), clear=np.zeros_like(every(pairs[1], 5).clear))
    known, taken = wake_residuals([pairs[0], dark], wide_jet(), None)
    at = {round(lag, 3): value for lag, value in zip(known.lags.times, known.clear, strict=True)}
    assert taken.clear[[0, 1, 4]] == pytest.approx([at[0.0], at[0.05], at[0.2]], abs=0.0)
    between = np.interp(0.1, [0.08, 0.12], [at[0.08], at[0.12]])
    assert taken.clear[2] == pytest.approx(between)


@pytest.mark.parametrize("step", [2, 5])
def test_gusts_of_slow_flights_have_the_time_of_fast_ones(step: int) -> None:
    rng = np.random.default_rng(5)
    records = []
    for k in range(9):
        motion = orbit(40.0 * step, (0.6,), k)
        push = 0.2 * rng.standard_normal(motion.t.size) + 0.15 * process(motion.t.size, 0.3, rng)
        records.append(every(with_push(still_record(f"clear{k}", motion), push[:, None]), step))
    assert np.diff(records[0].motion.t)[0] == pytest.approx(step * DT)
    found = wind_term(records)
    assert found is not None
    assert_within(found.values, "wind.gust_std_mps2", 0.15)
    assert_within(found.values, "wind.gust_time_s", 0.3)


def test_lags_are_times_where_rows_are_lost(pairs: list[AirRecord]) -> None:
    """Counted in rows that are left, times are 0.7 of what they are."""
    thin = [lossy(record, seed) for seed, record in enumerate(pairs)]
    lags = flight_lags(thin[0].motion.t, LAGS)
    t, known = thin[0].motion.t, np.ones(thin[0].motion.t.size, dtype=bool)
    for lag, (first, second) in zip(lags.times, lagged_pairs(known, lags), strict=True):
        np.testing.assert_allclose(t[second] - t[first], lag, atol=1e-9)
        assert first.size > 0.4 * t.size  # 0.7 of the rows have the later one
    whole, found = (residual_term([HeldOutGroup(tuple(one), wide_jet())], None) for one in (pairs, thin))
    assert whole is not None
    assert found is not None
    assert found.term.time_s == pytest.approx(whole.term.time_s, rel=0.1)
    clear = [wake_residuals(one, wide_jet(), None)[0].clear for one in (pairs, thin)]
    np.testing.assert_allclose(clear[1], clear[0], atol=2e-3)  # noise 0.01 / sqrt(pairs)
