"""A flight is known by its heights at another rate, turned, mirrored and with noise, and is no other's."""

import os
from collections.abc import Callable
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from q2q_model.flights.duplicates.height_records import (
    Heights,
    height_records,
    heights_as_text,
    heights_from_text,
    hold_same_heights,
)
from q2q_model.flights.tables.flight_table import POS, flight_table
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.signals.values import Array, Rows

DATA = Path(os.environ.get("Q2Q_DATA", "../shared/data"))
T = np.linspace(0.0, 60.0, 6001)


def flight(seed: int, vehicles: int = 2) -> Array:
    """Return positions that deviate by 0.1 m, at up to 1 Hz, from a height of 1 m, (T, n, 3)."""
    knots = np.linspace(0.0, 60.0, 121)
    drawn = 0.1 * np.random.default_rng(seed).standard_normal((knots.size, vehicles, 3))
    return np.asarray(CubicSpline(knots, drawn)(T)) + np.array([0.0, 0.0, 1.0])


def noisy(pos: Array) -> Array:
    return pos + 0.001 * np.random.default_rng(9).standard_normal(pos.shape)


def kept(pos: Array, rows: Rows | slice) -> Heights:
    return height_records(T[rows], pos[rows])


COPIES: dict[str, Callable[[Array], Heights]] = {
    "every 4th row": lambda pos: kept(pos, slice(1, None, 4)),
    "30 % dropped": lambda pos: kept(pos, np.flatnonzero(np.random.default_rng(0).random(T.size) > 0.3)),
    "cut": lambda pos: kept(pos, slice(2011, 4507, 2)),
    "turned": lambda pos: kept(pos[..., [1, 0, 2]] * [1.0, -1.0, 1.0] + 0.3, slice(None, None, 2)),
    "mirrored": lambda pos: kept(pos * [-1.0, 1.0, 1.0], slice(None, None, 2)),
    "one vehicle": lambda pos: kept(pos[:, 1:], slice(7, None, 2)),
    "noise": lambda pos: kept(noisy(pos), slice(None)),
    "later": lambda pos: height_records(T[::3] + 1.7e9, pos[::3]),
    "a short hole": lambda pos: kept(pos, np.flatnonzero(abs(T - 30.0) > 0.1)),
}


@pytest.mark.parametrize("changed", COPIES.values(), ids=COPIES)
def test_a_copy_of_a_flight_is_known_by_its_heights_alone(changed: Callable[[Array], Heights]) -> None:
    known = height_records(T, flight(0))
    assert hold_same_heights(changed(flight(0)), known)
    assert hold_same_heights(known, changed(flight(0)))
    assert not hold_same_heights(changed(flight(1)), known)


def test_repetitions_of_one_path_that_differ_by_a_centimetre_are_two_flights() -> None:
    known = height_records(T, flight(0))
    assert not hold_same_heights(height_records(T, flight(0) + 0.1 * flight(1)), known)
    assert hold_same_heights(height_records(T, flight(0) + 0.003 * flight(1)), known)


def test_one_vehicle_that_flies_alike_does_not_make_two_flights_the_same() -> None:
    other = flight(1)
    other[:, 0] = flight(0)[:, 0]
    assert not hold_same_heights(height_records(T, other), height_records(T, flight(0)))


def test_rest_short_parts_and_parts_that_do_not_overlap_are_not_recognised() -> None:
    pos = flight(0)
    assert height_records(T, 0.005 * pos) == ()
    assert height_records(T, np.full_like(pos, np.nan)) == ()
    assert kept(pos, slice(0, 900)) == ()
    assert not hold_same_heights(kept(pos, slice(0, 2900)), kept(pos, slice(3000, None)))
    assert not hold_same_heights((), height_records(T, pos))


def test_records_are_read_as_they_were_written() -> None:
    records = height_records(T, flight(0))
    assert [one.size for one in records] == [298, 298]  # 5 a second, less the width of a mean
    for one, read in zip(records, heights_from_text(heights_as_text(records)), strict=True):
        np.testing.assert_allclose(read, one, rtol=1e-12)
    assert heights_from_text("no base64") == ()
    assert heights_from_text("AAAA") == ()


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no recorded flights in {DATA}: set Q2Q_DATA")
def test_repetitions_of_public_flights_are_different_flights_and_half_their_rows_the_same() -> None:
    files = [*DATA.glob("neural_swarm/dc21_swap_ss_0[1-3].parquet"), *DATA.glob("nanobench/B8*.parquet")]
    tables = [flight_table(read_columns(file)) for file in files]
    assert len(tables) == 5
    known = [height_records(one.t, one.vectors(POS)) for one in tables]
    for one, own in zip(tables, known, strict=True):
        assert hold_same_heights(height_records(one.t[1::2], one.vectors(POS)[1::2]), own)
    assert not any(hold_same_heights(*pair) for pair in combinations(known, 2))


def test_time_on_the_floor_makes_no_two_hovers_the_same() -> None:
    rng, records = np.random.default_rng(4), []
    for _ in range(2):
        drift = np.cumsum(rng.standard_normal(2000)) * 1.2e-4
        rise = np.clip(np.arange(9000) - 3000, 0, 200) / 200 - np.clip(np.arange(9000) - 5200, 0, 200) / 200
        height = rise + np.where(rise == 1.0, np.resize(drift, 9000), 0.0)
        pos = np.zeros((9000, 1, 3))
        pos[:, 0, 2] = height
        records.append(height_records(0.01 * np.arange(9000), pos))
    assert [one.size for one in records[0]] == [114]  # 23 s in the air
    assert not hold_same_heights(*records)
