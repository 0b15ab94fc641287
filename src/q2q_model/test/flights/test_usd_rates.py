"""Micro-SD logs of any rate become ticks of the fastest, with the holes of each by its own rate."""

import numpy as np
import pytest

from q2q_model.flights.tables.usd_flight import columns_of_logs
from q2q_model.flights.tables.usd_log import UsdLog
from q2q_model.signals.values import Array


def log(period: float, lost: slice = slice(0), seconds: float = 4.0) -> UsdLog:
    """Return a log of a vehicle at x = t, whose rows `lost` are missing."""
    t = np.delete(period * np.arange(round(seconds / period) + 1), lost)
    return UsdLog(t, {f"stateEstimate.{axis}": t for axis in "xyz"}, ())


def gaps(found: dict[str, Array], name: str) -> Array:
    return np.asarray(found["t"][found[f"{name}_gap"] > 0.0])


@pytest.mark.parametrize(
    ("period", "step"),
    [(0.002, 0.01), (0.01, 0.01), (0.02, 0.01), (0.025, 0.01), (1 / 30, 0.03), (0.05, 0.05), (0.1, 0.1)],
)
def test_logs_are_read_at_100_hz_and_those_slower_than_40_hz_at_their_own_rate(
    period: float, step: float
) -> None:
    found = columns_of_logs({"cf1": log(period)})
    np.testing.assert_allclose(np.diff(found["t"]), step, atol=1e-9)
    np.testing.assert_allclose(found["cf1_x"], found["t"], atol=1e-9)
    assert gaps(found, "cf1").size == 0


@pytest.mark.parametrize("slow", [0.02, 1 / 30, 0.1])
def test_a_slow_log_leaves_ticks_and_holes_of_a_fast_one_as_they_are(slow: float) -> None:
    holed = log(0.01, slice(51, 70))
    alone, beside = columns_of_logs({"cf1": holed}), columns_of_logs({"cf1": holed, "cf2": log(slow)})
    for name, values in alone.items():
        np.testing.assert_array_equal(beside[name], values)
    np.testing.assert_allclose(gaps(beside, "cf1"), 0.01 * np.arange(51, 70), atol=1e-9)
    assert gaps(beside, "cf2").size == 0


@pytest.mark.parametrize("period", [0.01, 0.02, 0.05, 0.1])
def test_a_missing_row_is_no_hole_and_two_are(period: float) -> None:
    fast = log(0.01)
    assert gaps(columns_of_logs({"cf1": log(period, slice(8, 9)), "cf2": fast}), "cf1").size == 0
    marked = gaps(columns_of_logs({"cf1": log(period, slice(8, 10)), "cf2": fast}), "cf1")
    assert marked.min() == pytest.approx(7 * period + 0.01)
    assert marked.max() == pytest.approx(10 * period - 0.01)
    assert marked.size == round(3 * period / 0.01) - 1


@pytest.mark.parametrize("beside", [{}, {"cf2": log(0.01)}])
def test_a_log_of_one_row_is_too_short(beside: dict[str, UsdLog]) -> None:
    with pytest.raises(ValueError, match=r"the logs have 0\.00 s in common \(minimum 1 s\)"):
        columns_of_logs({"cf1": log(0.01, slice(1, None))} | beside)
