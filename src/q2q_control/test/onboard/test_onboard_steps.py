"""Steps of the firmware app: ahead, at any time of its clock, on the ground and without sensors."""

import ctypes
import math

import numpy as np
import pytest
from native_apps import TICK_US, at_rest, hover, library, needs_cc

from q2q_control.onboard.model_header import AppRates
from q2q_control.onboard.native_app import NativeApp
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, GRAVITY


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
@pytest.mark.parametrize("rest_s", [0.1, 0.3, 1.9])
def test_a_second_take_off_while_the_supervisor_still_sees_a_flight_measures_nothing_on_the_ground(
    rest_s: float,
) -> None:
    """The firmware's supervisor takes a vehicle as flying for 2 s after its motors stopped."""
    app, ground = NativeApp(library(MEASURED_LAW, AppRates(), ResidualProcess())), hover(0.0, 0.0, 0.0)
    take_off, rest = np.repeat([0.5 * GRAVITY, GRAVITY], [150, 500]), np.zeros(round(500 * rest_s))
    thrusts = np.concatenate([take_off, rest, take_off])
    etas = np.array([app.step(at_rest(2000 * k, ground, thrust=one)) for k, one in enumerate(thrusts)])
    first, second = etas[: take_off.size], etas[-take_off.size :]
    assert np.all(etas[take_off.size : -take_off.size] == 0.0)
    assert np.all(second[:150] == 0.0)
    np.testing.assert_allclose(second, first, atol=1e-2)  # the rotors still turn a little
    assert np.abs(first).max() > 0.1  # from 0.9 of the weight on, what is missing of it seems to push


@needs_cc
@pytest.mark.parametrize("sick", range(9))
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_nothing_is_corrected_while_the_own_motion_is_not_finite(sick: int, value: float) -> None:
    """In whatever job of a step it comes, and afterwards all is as before."""
    app, own, bad = NativeApp(library(MEASURED_LAW)), hover(0.0, 0.0, 1.0), hover(0.0, 0.0, 1.0)
    bad[sick] = value
    app.hear_motion(1, 0, hover(0.0, 0.0, 1.4))
    steps = [app.step(at_rest(2000 * k, own, force_up=GRAVITY - 1.0)) for k in range(1, 110)]
    assert steps[-1] < -0.5
    assert [app.step(at_rest(2000 * k, bad, force_up=GRAVITY - 1.0)) for k in range(110, 114)] == [0.0] * 4
    assert app.step(at_rest(2000 * 114, own, force_up=GRAVITY - 1.0)) == pytest.approx(steps[-1], abs=0.1)


@needs_cc
@pytest.mark.parametrize("sick", [{"force_up": math.nan}, {"force_up": math.inf}, {"thrust": math.nan}])
def test_nothing_is_measured_while_the_force_or_the_thrust_is_not_finite(sick: dict[str, float]) -> None:
    """A residual that was found decays meanwhile with its time of 0.08 s."""
    app, own = NativeApp(library(MEASURED_LAW, AppRates(), ResidualProcess())), hover(0.0, 0.0, 1.0)
    for k in range(1050):
        found = app.step(at_rest(2000 * k, own, force_up=GRAVITY - (k >= 1000)))
    given = {"force_up": GRAVITY - 1.0, "thrust": GRAVITY} | sick
    left = [app.step(at_rest(2000 * k, own, **given)) for k in range(1050, 1090)]
    assert left[-1] == pytest.approx(found * math.exp(-0.08 / 0.08), rel=1e-3)


@needs_cc
def test_a_push_that_no_model_knows_is_found_within_the_time_of_the_residual() -> None:
    app, own = NativeApp(library(MEASURED_LAW, AppRates(), ResidualProcess())), hover(0.0, 0.0, 1.0)
    for k in range(1000):
        app.step(at_rest(2000 * k, own))
    found = [app.step(at_rest(2000 * k, own, force_up=GRAVITY - 1.0)) for k in range(1000, 1050)]
    ahead = math.exp(-CRAZYFLIE_2_0.thrust_lag / 0.08)  # left of it when the rotors have answered
    assert np.all(np.diff(found[:20]) < 0.0)
    assert -ahead < found[-1] < -0.5 * ahead
