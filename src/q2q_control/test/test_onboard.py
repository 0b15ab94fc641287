"""The firmware app in C is the Python law, uses no heap, and outlives what radios and sensors do."""

import ctypes
import math
import os
import re
import shutil
import subprocess
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from resting_signals import resting_state

from q2q_control.onboard.app_folder import CORE, write_app
from q2q_control.onboard.model_header import STALE_S, AppRates, UnsupportedModelError, model_header
from q2q_control.onboard.native_app import FLAGS, NativeApp, StepInput, compile_app
from q2q_model.bag.flight_in_bag import read_flight
from q2q_model.downwash.correction.corrected_predictor import ResidualCorrector
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, PAPER_LAW, Jet
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.flights.tables.table_file import read_columns
from q2q_model.geometry.rotations import quat_from_euler, rotate
from q2q_model.model_files.model_file import ModelFile
from q2q_model.signals.values import Array, Interference, SwarmState
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY

needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler: install one to test the app")
DATA = Path(os.environ.get("Q2Q_DATA", Path(__file__).parents[3].parent / "shared" / "data"))
FLIGHTS = (
    Path(__file__).parents[3] / "bags" / "table2_4",
    DATA / "neural_swarm" / "dc21_randomwalk_sss_00.parquet",
)
TICK_US = 10_000
NAMES = tuple(f"cf{k}" for k in range(6))
STACKED = replace(MOVING_LAW, loading=0.6, absorption=1.5, velocity_share=0.6)
"""Jet of real triples: docs/real_flights.md."""
TICKS = AppRates(broadcast_hz=100.0)
"""Every tick of a motion below is broadcast, as the predictor sees it."""
EQUAL = 1e-5
"""[m/s^2]: single precision leaves 1e-7 of a jet of up to 5 m/s^2, and of metres over its width of 3 cm."""
UP = np.array([0.0, 0.0, 1.0])


@lru_cache(maxsize=8)
def library(jet: Jet, rates: AppRates = TICKS, residual: ResidualProcess | None = None):
    with TemporaryDirectory() as made:
        write_app(Path(made) / "app", ModelFile(jet, residual=residual), CRAZYFLIE_2_0, rates)
        return compile_app(Path(made) / "app")


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


def at_rest(now_us: int, own: Array, **values: float) -> StepInput:
    return StepInput(now_us, own, **({"force_up": GRAVITY, "thrust": GRAVITY, "flying": True} | values))


def hover(x: float, y: float, z: float) -> Array:
    return np.array([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])


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


@needs_cc
def test_a_neighbour_is_dead_reckoned_between_broadcasts_and_forgotten_when_it_is_silent() -> None:
    app, own, speed = NativeApp(library(MEASURED_LAW, AppRates())), hover(0.0, 0.0, 1.0), 0.5
    for k in range(20):
        source = hover(speed * 0.02 * k - 0.25, 0.0, 1.5)
        source[3] = speed
        app.hear_motion(7, 20_000 * k, source)
    width, peak = MEASURED_LAW.width, MEASURED_LAW.strength * math.exp(-MEASURED_LAW.decay_rate * 0.1)
    for age in (0.0, 0.1, STALE_S - 0.01):
        x = speed * (0.38 + age - 0.5 / MEASURED_LAW.travel_speed) - 0.25  # where the air left the source
        eta = app.downwash(own, 380_000 + round(1e6 * age))
        assert eta == pytest.approx(-peak * math.exp(-x * x / (2 * width * width)), rel=1e-4)
    assert app.downwash(own, 380_000 + round(1e6 * STALE_S) + 1000) == 0.0


@needs_cc
def test_a_prediction_ahead_is_that_of_the_moment_when_it_comes_true() -> None:
    source, own = hover(-0.05, 0.0, 1.5), hover(0.02, 0.0, 1.0)
    source[3], own[5] = 0.4, 0.3
    app = NativeApp(library(MOVING_LAW))
    for k in range(60):
        app.hear_motion(1, TICK_US * k, source + k * 0.01 * np.array([0.4, *np.zeros(8)]))
    now, later = 59 * TICK_US, 66 * TICK_US
    moved = own + 0.07 * np.array([0.0, 0.0, 0.3, *np.zeros(6)])
    assert app.downwash(own, now, 0.07) == pytest.approx(app.downwash(moved, later), rel=1e-4)
    assert app.downwash(own, now, 0.07) != pytest.approx(app.downwash(own, now), rel=0.05)


@needs_cc
def test_broadcasts_round_to_millimetres_and_are_clipped() -> None:
    app = NativeApp(library(MEASURED_LAW))
    packet = app.broadcast(200, np.array([1.2344, -2.0, 40.0, -0.5, 0.0, 1e9, 0.3, -0.4, math.sqrt(0.75)]))
    assert packet is not None
    assert packet[0] == 200
    numbers = np.frombuffer(packet[1:], dtype="<i2")
    np.testing.assert_array_equal(numbers, [1234, -2000, 32767, -500, 0, 32767, 3000, -4000])
    above, own = hover(0.01, 0.0, 1.4), hover(0.0, 0.0, 1.0)
    sent = app.broadcast(200, above)
    assert sent is not None
    assert app.hear(sent, 0)
    other = NativeApp(library(MEASURED_LAW))
    assert other.hear_motion(200, 0, above)
    assert app.downwash(own, 0) == pytest.approx(other.downwash(own, 0), abs=1e-6)


@needs_cc
@pytest.mark.parametrize("sick", [0, 5, 8])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_motion_that_is_not_finite_is_not_broadcast(sick: int, value: float) -> None:
    """It became a valid packet: position 0, where others then felt a vehicle."""
    motion = hover(1.0, 2.0, 3.0)
    motion[sick] = value
    assert NativeApp(library(MEASURED_LAW)).broadcast(3, motion) is None


@needs_cc
def test_a_silent_neighbour_stays_forgotten_when_the_clock_has_wrapped() -> None:
    """Stamps are of 32 bits: half their period later an age is negative, a whole one later it is new."""
    heard, above, own = 1_000_000, hover(0.0, 0.0, 1.4), hover(0.0, 0.0, 1.0)
    fresh, app = NativeApp(library(MEASURED_LAW)), NativeApp(library(MEASURED_LAW))
    assert app.hear_motion(2, heard, above)
    assert app.downwash(own, heard) == pytest.approx(-MEASURED_LAW.strength, rel=1e-5)
    assert app.downwash(own, (heard + 2_150_000_000) % 2**32) == 0.0  # no step since: 35.8 min, age negative
    app.step(at_rest(heard + 300_000, own))  # steps go on every 2 ms; one is enough to forget
    for later in (2_150_000_000, 4_000_000_000, 2**32 + 100_000):
        assert app.downwash(own, (heard + later) % 2**32) == 0.0
    back, beside = (heard + 2_200_000_000) % 2**32, hover(0.02, 0.0, 1.4)
    assert app.hear_motion(2, back, beside)
    assert fresh.hear_motion(2, back, beside)
    assert app.downwash(own, back) == fresh.downwash(own, back) < -0.5


@needs_cc
def test_a_late_packet_is_refused_and_keeps_the_newer_ones() -> None:
    app, own = NativeApp(library(MEASURED_LAW)), hover(0.0, 0.0, 1.0)
    assert app.hear_motion(2, 40_000, hover(0.0, 0.0, 1.4))
    assert not app.hear_motion(2, 20_000, hover(5.0, 0.0, 1.4))
    assert app.downwash(own, 40_000) == pytest.approx(-MEASURED_LAW.strength, rel=1e-5)


@needs_cc
@pytest.mark.parametrize("start", [100_000, 2**31 + 1_000_000, 2**32 - 50_000])
def test_the_first_step_may_come_at_any_time_of_the_clock(start: int) -> None:
    """A first step at 2^31 us or later was one of -36 min: the rotors' thrust was NaN for ever."""
    apps, own, above = [NativeApp(library(MOVING_LAW)) for _ in range(2)], hover(0, 0, 1), hover(0, 0, 1.4)
    etas = np.empty((300, 2))
    for k in range(300):
        for column, (app, first) in enumerate(zip(apps, (0, start), strict=True)):
            now = (first + 2000 * k) % 2**32
            if k % 10 == 0:
                app.hear_motion(1, now, above)
            etas[k, column] = app.step(at_rest(now, own, force_up=GRAVITY - 1.0))
    assert np.array_equal(etas[:, 0], etas[:, 1])
    assert etas[-1, 0] < -1.0


@needs_cc
def test_a_measurement_without_time_since_the_last_teaches_no_offset() -> None:
    app, memory = library(MEASURED_LAW), (ctypes.c_float * 5)(0.0, 0.01)
    app.q2q_measure(memory, ctypes.c_float(1.0), ctypes.c_float(0.0), ctypes.c_float(0.0))
    assert memory[2] == 0.0  # 0 s of 0 s in clear air: NaN
    app.q2q_measure(memory, ctypes.c_float(1.0), ctypes.c_float(0.0), ctypes.c_float(0.01))
    assert memory[2] == 1.0  # the mean of one


@needs_cc
def test_of_six_neighbours_the_last_is_refused_until_one_is_silent() -> None:
    app = NativeApp(library(MEASURED_LAW))
    assert [app.hear_motion(k, 1000, hover(0.0, 0.0, 1.0 + k)) for k in range(1, 7)] == [True] * 5 + [False]
    assert not app.hear_motion(1, 1000, hover(0.0, 0.0, 2.0))  # a repeated stamp
    assert not app.hear_motion(1, 2000, np.full(9, np.nan))
    assert app.hear_motion(6, 1000 + round(1e6 * STALE_S) + 100_000, hover(0.0, 0.0, 1.4))


@needs_cc
def test_on_the_ground_and_with_sensors_that_fail_nothing_is_corrected() -> None:
    app, above, own = NativeApp(library(MEASURED_LAW)), hover(0.0, 0.0, 1.4), hover(0.0, 0.0, 1.0)
    app.hear_motion(1, 0, above)
    for k in range(1, 10):  # motors that spin up on the ground measure what the ground carries
        assert app.step(at_rest(2000 * k, own, thrust=0.5 * GRAVITY)) == 0.0
    steps = [app.step(at_rest(2000 * k, own, force_up=math.nan)) for k in range(10, 100)]
    assert steps[-1] == pytest.approx(-MEASURED_LAW.strength, rel=1e-5)  # the prediction alone
    assert app.step(at_rest(200_000, np.full(9, np.nan), thrust=math.nan)) == 0.0
    pushed = [app.step(at_rest(200_000 + 2000 * k, own, force_up=-1e6)) for k in range(1, 20)]
    assert min(pushed) == pytest.approx(-0.5 * GRAVITY)
    assert app.step(at_rest(250_000, own, flying=False)) == 0.0


@needs_cc
def test_a_push_that_no_model_knows_is_found_within_the_time_of_the_residual() -> None:
    app, own = NativeApp(library(MEASURED_LAW, AppRates(), ResidualProcess())), hover(0.0, 0.0, 1.0)
    for k in range(1000):
        app.step(at_rest(2000 * k, own))
    found = [app.step(at_rest(2000 * k, own, force_up=GRAVITY - 1.0)) for k in range(1000, 1050)]
    ahead = math.exp(-CRAZYFLIE_2_0.thrust_lag / 0.08)  # left of it when the rotors have answered
    assert np.all(np.diff(found[:20]) < 0.0)
    assert -ahead < found[-1] < -0.5 * ahead


@needs_cc
def test_the_core_compiles_strictly_and_calls_no_heap(tmp_path: Path) -> None:
    write_app(tmp_path, ModelFile(STACKED), CRAZYFLIE_2_0)
    strict = [*FLAGS, "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Wvla", "-c"]
    subprocess.run(["cc", *strict, *CORE], cwd=tmp_path, check=True)
    listed = subprocess.run(["nm", "-u", *(name[:-1] + "o" for name in CORE)], cwd=tmp_path, check=True,
                            capture_output=True, text=True).stdout  # fmt: skip
    called = {line.split()[1] for line in listed.splitlines() if line.startswith(" ")}
    own = {name for name in called if name.startswith("q2q_")}
    arithmetic = {"expf", "sqrtf", "roundf", "memset", "memcpy"}
    assert called - own <= arithmetic | {"_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail"}


@needs_cc
def test_the_glue_uses_the_firmware_as_documented_and_every_source_is_in_the_build(tmp_path: Path) -> None:
    app, interface = tmp_path / "app", tmp_path / "firmware"
    write_app(app, ModelFile(MEASURED_LAW), CRAZYFLIE_2_0)
    interface.mkdir()
    glue = (app / "app_main.c").read_text(encoding="utf-8")
    for name in re.findall(r'#include "(.*)"', glue):
        if not (app / name).exists():
            (interface / name).write_text('#include "firmware.h"\n', encoding="utf-8")
    (interface / "firmware.h").write_bytes((Path(__file__).parent / "cortex_m4" / "firmware.h").read_bytes())
    checks = ["-std=gnu11", "-Wall", "-Wextra", "-Werror", "-Wno-unused-const-variable", "-fsyntax-only"]
    subprocess.run(["cc", *checks, f"-I{interface}", "app_main.c"], cwd=app, check=True)
    built = set(re.findall(r"(\w+)\.o", (app / "Kbuild").read_text(encoding="utf-8")))
    assert built == {path.stem for path in app.glob("*.c")} == {"app_main", *(name[:-2] for name in CORE)}


def test_models_that_are_no_jet_and_folders_that_are_not_empty_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UnsupportedModelError, match="not a NoInteraction"):
        model_header(ModelFile(NoInteraction()), CRAZYFLIE_2_0)
    (tmp_path / "mine.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(FileExistsError, match="not an empty folder"):
        write_app(tmp_path, ModelFile(MEASURED_LAW), CRAZYFLIE_2_0)
    assert [one.name for one in tmp_path.iterdir()] == ["mine.txt"]
