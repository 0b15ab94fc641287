"""The firmware app in C is the Python law."""

import ctypes
import os
from pathlib import Path

import numpy as np
import pytest
from native_apps import STACKED, TICK_US, at_rest, library, needs_cc
from resting_signals import resting_state

from q2q_control.onboard.model_header import AppRates
from q2q_control.onboard.native_app import NativeApp
from q2q_model.bag.flight_in_bag import read_flight
from q2q_model.downwash.correction.corrected_predictor import ResidualCorrector
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, PAPER_LAW, Jet
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.geometry.rotations import quat_from_euler, rotate
from q2q_model.signals.values import Array, Interference, SwarmState

DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[4].parent / "shared" / "data"))
FLIGHTS = (
    Path(__file__).parents[4] / "bags" / "table2_4",
    DATA / "neural_swarm" / "dc21_randomwalk_sss_00.parquet",
)
NAMES = tuple(f"cf{k}" for k in range(6))
EQUAL = 1e-5
"""[m/s^2]: single precision leaves 1e-7 of a jet of up to 5 m/s^2, and of metres over its width of 3 cm."""
UP = np.array([0.0, 0.0, 1.0])


def motions(ticks: int, seed: int) -> tuple[Array, Array]:
    """Return smooth random motions in single precision, (ticks, 6, 9), and their attitudes (ticks, 6, 4)."""
    rng = np.random.default_rng(seed)
    t = np.arange(ticks)[:, None, None] * 1e-6 * TICK_US
    start = rng.uniform([-0.15, -0.15, 0.3], [0.15, 0.15, 1.8], (6, 3))
    swing, rate = rng.uniform(-0.15, 0.15, (6, 3)), rng.uniform(2.0, 6.0, (6, 3))
    pos, vel = start + swing * np.sin(rate * t), swing * rate * np.cos(rate * t)
    angles = 0.3 * np.sin(3.0 * t + rng.uniform(0.0, 6.0, (6, 3)))
    quat = quat_from_euler(angles[..., 0], angles[..., 1], angles[..., 2])
    values = np.concatenate([pos, vel, rotate(quat, UP)], axis=-1)
    return values.astype(np.float32).astype(np.float64), quat


def state_at(tick: int, motion: Array, quat: Array) -> SwarmState:
    n = len(motion)
    return resting_state(1e-6 * TICK_US * tick, NAMES[:n], motion[:, :3], vel=motion[:, 3:6], quat=quat)


def largest_difference(jet: Jet, motion: Array, quat: Array, start_us: int = 0) -> tuple[float, float]:
    """Return the largest difference of app and predictor for vehicle 0, and the largest downwash."""
    app, predictor, worst, largest = NativeApp(library(jet)), InteractionPredictor(jet), 0.0, 0.0
    for tick, now in enumerate(motion):
        now_us = (start_us + tick * TICK_US) % 2**32
        for j in range(1, len(now)):
            assert app.hear_motion(j, now_us, now[j])
        app.step(at_rest(now_us, now[0]))
        eta = predictor.update(state_at(tick, now, quat[tick])).acc[0, 2]
        app.downwash(now[0], now_us)
        app.renew_strengths(now[0], now_us)
        worst = max(worst, abs(app.downwash(now[0], now_us) - eta))
        largest = max(largest, abs(eta))
    return worst, largest


@needs_cc
@pytest.mark.parametrize("jet", [PAPER_LAW, MEASURED_LAW, MOVING_LAW, STACKED])
def test_the_app_predicts_as_python_does(jet: Jet) -> None:
    found = np.array([largest_difference(jet, *motions(100, seed)) for seed in range(3)])
    assert found[:, 0].max() < EQUAL
    assert found[:, 1].max() > 0.5 * jet.strength


@needs_cc
def test_the_app_predicts_as_python_does_while_its_clock_wraps() -> None:
    worst, largest = largest_difference(MOVING_LAW, *motions(100, 1), start_us=2**32 - 50 * TICK_US)
    assert worst < EQUAL
    assert largest > 1.0


def recorded(path: Path) -> tuple[Array, Array]:
    """Return motions and attitudes around the closest pass of a flight in a bag or a table."""
    if path.is_dir():
        flight = read_flight(path)
        parts = [flight.pos, flight.vel, flight.quat]
    else:
        columns = read_columns(path)
        names = sorted({name.split("_")[0] for name in columns if name.startswith("cf")})
        words = (("x", "y", "z"), ("vx", "vy", "vz"), ("qx", "qy", "qz", "qw"))
        rows = [[[columns[f"{name}_{word}"] for word in one] for name in names] for one in words]
        parts = [np.moveaxis(np.array(one), 2, 0) for one in rows]
    apart = np.linalg.norm(parts[0][:, 0, :2] - parts[0][:, 1, :2], axis=-1)
    middle = max(int(np.nanargmin(apart)), 300)
    pos, vel, quat = (part[middle - 300 : middle + 300].astype(np.float64) for part in parts)
    values = np.concatenate([pos, vel, rotate(quat, UP)], axis=-1)
    return values.astype(np.float32).astype(np.float64), quat


@needs_cc
@pytest.mark.parametrize("flight", FLIGHTS, ids=lambda path: path.stem)
def test_the_app_predicts_as_python_does_along_recorded_flights(flight: Path) -> None:
    if not flight.exists():
        pytest.skip(f"no recorded flight at {flight}: set Q2Q_DATA")
    motion, quat = recorded(flight)
    turned = [np.roll(one, -1, axis=1) for one in (motion, quat)]  # another vehicle is vehicle 0
    found = np.array([largest_difference(STACKED, *pair) for pair in ((motion, quat), turned)])
    assert found[:, 0].max() < EQUAL
    assert found[:, 1].max() > 1.0


@needs_cc
def test_the_app_corrects_as_python_does() -> None:
    process = ResidualProcess(noise=0.3)
    app, rng, names = (
        library(MEASURED_LAW, AppRates(step_hz=100.0), process),
        np.random.default_rng(1),
        ("cf1",),
    )
    python, memory = ResidualCorrector(process), (ctypes.c_float * 5)(0.0, process.floor**2)
    app.q2q_residual.restype = ctypes.c_float
    eta = np.float32(np.where(np.arange(600) % 200 < 100, 0.0, -1.5) + 0.02 * rng.standard_normal(600))
    push = np.float32(eta + 0.2 + 0.3 * rng.standard_normal(600))
    push[50:60] = np.nan
    for k, (expected, measured) in enumerate(zip(eta, push, strict=True)):
        zero, one = np.zeros((1, 3)), np.array([[0.0, 0.0, float(expected)]])
        prediction = Interference(t=0.01 * k, names=names, acc=one, std=zero, status=np.zeros(1, np.uint8))
        corrected = python.update(prediction).acc[0, 2]
        left = float(app.q2q_residual(memory, ctypes.c_float(0.01 if k else 1.0)))
        assert expected + left == pytest.approx(corrected, abs=EQUAL)
        python.measure(0.01 * k, names, np.array([float(measured)]))
        app.q2q_measure(memory, *(ctypes.c_float(one) for one in (measured, expected, 0.01 if k else 1.0)))
    assert memory[2] == pytest.approx(0.2, abs=0.1)  # the offset, from 3 s of clear air
