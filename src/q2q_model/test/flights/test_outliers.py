"""Tests of the batch rule of section 2.2 against synthetic tracks and real flights."""

import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from q2q_model.estimation.association.outlier_thresholds import OutlierThresholds
from q2q_model.flights.outliers import find_outliers, repair
from q2q_model.signals.values import Array

RATE = 100.0
DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[4].parent / "shared" / "data"))
seeds = st.integers(0, 2**32 - 1)


def _flight(samples: int = 600) -> tuple[Array, Array]:
    """Fly two vehicles on ellipses at up to 1 m/s, one 0.5 m above the other."""
    t = np.arange(samples) / RATE
    one = np.stack([np.sin(t), 0.5 * np.cos(2.0 * t), 1.0 + 0.1 * np.sin(3.0 * t)], axis=-1)
    two = np.stack([np.cos(t), 0.5 * np.sin(2.0 * t), 1.5 + 0.1 * np.cos(3.0 * t)], axis=-1)
    return t, np.stack([one, two], axis=1)


def test_a_smooth_flight_has_no_outlier():
    t, pos = _flight()
    assert not find_outliers(t, pos).any()


@pytest.mark.parametrize("rate", [200.0, 100.0, 50.0, 20.0, 12.0, 8.0])
@pytest.mark.parametrize("speed", [1.0, 2.0, 3.0])
def test_a_circle_of_1_m_has_no_outlier_at_any_rate(rate: float, speed: float):
    """In the 50 ms to a neighbour of the median it leaves a line by up to 9 m/s^2 (50 ms)^2 / 2 = 11 mm."""
    t = np.arange(0.0, 10.0, 1.0 / rate)
    assert not find_outliers(t, np.stack([np.cos(speed * t), np.sin(speed * t), 0.0 * t], axis=-1)).any()


@pytest.mark.parametrize("rows_apart", [2, 10])
def test_rows_of_other_topics_and_vehicles_do_not_change_the_outliers(rows_apart: int):
    """A log of the motors at 1 kHz beside poses at 100 Hz: times are counted in samples of the vehicle."""
    t = np.arange(0.0, 10.0, 0.01)
    pos = np.stack([np.cos(3.0 * t), np.sin(3.0 * t), 0.0 * t], axis=-1)
    pos[t > 6.0] += [3.0, 0.0, 0.0]  # carried away
    pos[200:204] += [0.0, 0.0, 0.5]
    rows = np.arange(t.size) * rows_apart
    joined = np.full((t.size * rows_apart, 3), np.nan)
    joined[rows] = pos
    found = find_outliers(np.arange(len(joined)) * 0.01 / rows_apart, joined)
    np.testing.assert_array_equal(found[rows], find_outliers(t, pos))
    assert np.flatnonzero(found[rows]).tolist() == [200, 201, 202, 203]


@pytest.mark.parametrize("at_once", [2, 5])
def test_of_poses_that_come_several_at_once_only_outliers_are_found(at_once: int):
    """Stamped on receipt, 1 ms apart: the median of all steps may be 1 ms, and 50 ms are 5 samples still."""
    sample = np.arange(800)
    t, received = 0.01 * sample, 0.01 * at_once * (sample // at_once) + 0.001 * (sample % at_once)
    pos = np.stack([np.cos(2.0 * t), np.sin(2.0 * t), 0.0 * t], axis=-1)
    pos[50::100] += [0.0, 0.0, 0.6]
    assert np.flatnonzero(find_outliers(received, pos)).tolist() == list(range(50, 800, 100))


@pytest.mark.parametrize("rate", [100.0, 20.0])
def test_a_vehicle_that_is_carried_away_is_accepted_after_2_s_at_any_rate(rate: float):
    t = np.arange(0.0, 10.0, 1.0 / rate)
    for length, found in ((1.5, round(1.5 * rate)), (2.5, 0)):
        pos = np.zeros((t.size, 3))
        pos[t > t[-1] - length] += [3.0, 0.0, 0.0]
        assert find_outliers(t, pos).sum() == pytest.approx(found, abs=1)  # where the step is, by rounding


def test_a_flight_without_samples_or_vehicles_has_no_outlier():
    assert find_outliers(np.zeros(0), np.zeros((0, 2, 3))).shape == (0, 2)
    assert find_outliers(np.zeros(0), np.zeros((0, 3))).shape == (0,)
    assert find_outliers(np.arange(3.0), np.zeros((3, 0, 3))).shape == (3, 0)


@given(seeds, st.integers(1, 5), st.floats(0.08, 30.0))
@settings(max_examples=25, deadline=None)
def test_a_short_burst_is_found_and_nothing_else(seed: int, length: int, size: float):
    rng = np.random.default_rng(seed)
    t, pos = _flight()
    start = int(rng.integers(20, 570))
    away = rng.standard_normal((length, 3))
    # the threshold is 40 mm; five outliers in the window move the median by up to 2.5 samples of 14 mm
    pos[start : start + length, 1] += size * away / np.linalg.norm(away, axis=-1, keepdims=True)
    found = find_outliers(t, pos)
    expected = np.zeros_like(found)
    expected[start : start + length, 1] = True
    assert np.array_equal(found, expected)


def test_a_minute_at_1_khz_takes_the_memory_of_a_few_copies_of_its_positions():
    t = np.arange(60_000) / 1000.0
    pos = np.stack([np.cos(t), np.sin(t), 1.0 + 0.0 * t], axis=-1)
    pos[30_000:30_040, 2] += 0.08  # less than half of a window of 101 samples
    tracemalloc.start()
    found = find_outliers(t, pos)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert np.flatnonzero(found).tolist() == list(range(30_000, 30_040))
    assert peak < 10 * pos.nbytes  # windows of 101 samples are 101 copies


@given(st.integers(1, 100))
@settings(max_examples=10, deadline=None)
def test_swapped_markers_are_outliers_of_both_vehicles(length: int):
    t, pos = _flight()
    pos[200 : 200 + length] = pos[200 : 200 + length, ::-1].copy()
    found = find_outliers(t, pos)
    assert found[200 : 200 + length].all()
    assert found.sum() == 2 * length


def test_a_vehicle_carried_elsewhere_for_good_is_accepted():
    t, pos = _flight(900)
    pos[450:, 0] += [3.0, 0.0, 0.0]
    assert not find_outliers(t, pos).any()


def test_a_sample_that_is_no_number_or_outside_every_room_is_an_outlier():
    t, pos = _flight()
    pos[100, 0, 2], pos[101, 0], pos[102, 1] = np.nan, np.inf, 1e300
    found = find_outliers(t, pos)
    assert found[100, 0]
    assert found[101, 0]
    assert found[102, 1]
    assert found.sum() == 3


def test_a_spike_at_the_end_of_a_gap_does_not_take_the_flight_with_it():
    t, pos = _flight()
    pos[200:240, 0] = np.nan
    pos[240, 0] += [0.3, 0.0, 0.0]
    found = find_outliers(t, pos)
    assert found[200:241, 0].all()
    assert found.sum() == 41


def test_old_frames_under_new_stamps_are_found_where_the_track_then_jumps():
    t, pos = _flight()
    pos[300:310, 0] = pos[299, 0]  # 0.1 s at up to 1 m/s: then 0.1 m in one step
    found = find_outliers(t, pos)
    assert found[300:310, 0].all()
    assert found.sum() == 10


def test_repair_draws_lines_between_neighbours_and_keeps_good_samples():
    t, pos = _flight()
    bad = np.zeros(pos.shape[:2], dtype=bool)
    bad[300:305, 0] = True
    mended = repair(t, np.where(bad[..., None], 99.0, pos), bad)
    assert np.array_equal(mended[~bad], pos[~bad])
    # sagitta of a chord of 6 samples: a T^2 / 8 with a <= 2 m/s^2, T = 0.06 s
    assert np.abs(mended - pos).max() < 2.0 * 0.06**2 / 8.0
    middle = 0.5 * (mended[300, 0] + mended[304, 0])
    assert np.allclose(mended[302, 0], middle, atol=1e-12)  # rounding of coordinates near 1


def test_a_track_without_a_good_sample_stays_unknown():
    t, pos = _flight(50)
    bad = np.ones(pos.shape[:2], dtype=bool)
    assert np.isnan(repair(t, pos, bad)).all()


def test_a_time_that_falls_is_refused_with_the_place():
    t, pos = _flight(50)
    t[10] = t[9]
    with pytest.raises(ValueError, match=r"t must increase; 0\.09 follows 0\.09"):
        find_outliers(t, pos)


def test_a_jump_within_a_raised_threshold_is_no_outlier():
    t, pos = _flight()
    pos[300, 0] += [0.1, 0.0, 0.0]
    assert find_outliers(t, pos).sum() == 1
    assert find_outliers(t, pos, OutlierThresholds(speed_max=30.0, jump_max=0.2)).sum() == 0


@pytest.mark.skipif(not DATA.is_dir(), reason=f"real flights are not at {DATA}: set Q2Q_DATA")
@pytest.mark.parametrize("name", ["dc19_swap_ss_02", "dc21_swap_ss_05"])
def test_real_flights_are_clean_and_what_is_injected_is_found(name: str):
    pyarrow = pytest.importorskip("pyarrow.parquet")
    table = pyarrow.read_table(DATA / "neural_swarm" / f"{name}.parquet")
    columns = [[f"{cf}_{axis}" for axis in "xyz"] for cf in ("cf50", "cf51")]
    pos = np.stack([np.stack([table[c].to_numpy() for c in cf], axis=-1) for cf in columns], axis=1).astype(
        float
    )
    t = table["t"].to_numpy()
    assert not find_outliers(t, pos).any()
    rng = np.random.default_rng(0)
    injected = rng.random(pos.shape[:2]) < 0.01
    away = rng.standard_normal(pos.shape)
    spoiled = pos + np.where(
        injected[..., None], 0.1 * away / np.linalg.norm(away, axis=-1, keepdims=True), 0.0
    )
    found = find_outliers(t, spoiled)
    assert found[injected].mean() >= 0.99  # what the project promises
    assert found[~injected].mean() <= 0.001
