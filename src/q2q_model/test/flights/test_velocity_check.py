"""Velocities that are not the derivatives of the positions are refused, whatever positions do."""

import os
from pathlib import Path

import numpy as np
import pytest

from q2q_model.flights.tables.flight_table import VEL, flight_table
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.flights.units_and_frames.velocity_check import check_velocities
from q2q_model.signals.values import Array

DATA = Path(os.environ.get("Q2Q_DATA", "../shared/data")) / "neural_swarm"
T = np.linspace(0.0, 9.99, 1000)
CIRCLE: Array = 0.5 * np.stack([np.sin(T), np.cos(T), np.sin(0.7 * T)], axis=1)[:, None]
"""Positions of one vehicle [m], (T, 1, 3)."""
SPEED: Array = 0.5 * np.stack([np.cos(T), -np.sin(T), 0.7 * np.cos(0.7 * T)], axis=1)[:, None]
"""Their derivative [m/s]."""


def check(pos: Array, vel: Array) -> None:
    check_velocities(T, ("cf1",), pos, vel)


@pytest.mark.parametrize(
    ("scale", "message"),
    [
        ((1e3, 1e3, 1e3), "vx of cf1 is 1e[+]03 times the change of x by time, expected 0.33 to 3"),
        ((1.0, 3.6, 1.0), "vy of cf1 is 3.6[0-9]? times the change of y"),
        ((1.0, 1.0, -1.0), "vz of cf1 is -1 times the change of z"),
        ((0.0, 0.0, 0.0), "vx of cf1 is 0 times .* or leave vx, vy, vz out"),
    ],
)
def test_velocities_of_another_unit_or_sign_are_refused(
    scale: tuple[float, float, float], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        check(CIRCLE, SPEED * scale)


def test_noise_single_wrong_values_gaps_and_a_delay_are_not() -> None:
    noise = np.random.default_rng(0).standard_normal((2, 1000, 1, 3))
    pos, vel = CIRCLE + 0.01 * noise[0], SPEED + 0.05 * noise[1]
    pos[300], vel[500] = 40.0, 1e200
    pos[700:720], vel[100:150] = np.nan, np.nan
    check(pos, vel)
    check(CIRCLE, np.roll(SPEED, 20, axis=0))


def test_a_vehicle_that_hardly_moves_is_not_judged() -> None:
    check(0.2 * CIRCLE, -SPEED)  # 0.1 m/s
    check(np.zeros_like(CIRCLE), SPEED)
    check(np.full_like(CIRCLE, np.nan), SPEED)


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no recorded flights in {DATA}: set Q2Q_DATA")
def test_public_flights_have_velocities_of_their_positions_in_metres_per_second_alone() -> None:
    for file in sorted(DATA.glob("*.parquet")):
        columns = read_columns(file)
        flight_table(columns)
        with pytest.raises(ValueError, match="times the change of"):
            flight_table({name: 1e3 * one if name.endswith(VEL) else one for name, one in columns.items()})


@pytest.mark.parametrize("noise", [0.02, 0.05, 0.1])
def test_noisy_positions_of_a_hover_or_a_slow_circle_are_not_judged(noise: float) -> None:
    drawn = noise * np.random.default_rng(2).standard_normal(CIRCLE.shape)
    check(0.02 * CIRCLE + drawn, 0.02 * SPEED)
    check(0.4 * CIRCLE + drawn, 0.4 * SPEED)
