"""The filter of height and residual has the gain of its process, and needs no accelerometer."""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are
from scipy.signal import lfilter

from q2q_control.disturbance.accelerometer_residual import AccelerometerResidual, ExplainedTick
from q2q_control.disturbance.observer import MeasuredRows, Measurement
from q2q_control.disturbance.residual_observer import (
    BIAS,
    BIAS_S,
    BIAS_STD,
    CLIMB,
    HEIGHT,
    HEIGHT_STD,
    OFFSET,
    OFFSET_STD,
    RESIDUAL,
    ResidualObserver,
)
from q2q_model.downwash.correction.corrected_predictor import OFFSET_S
from q2q_model.downwash.correction.residual_process import OLDEST, REAL_FLIGHTS, ResidualProcess
from q2q_model.geometry.rotations import quat_from_euler
from q2q_model.signals.values import Array, SwarmImu
from q2q_model.vehicle.constants import GRAVITY

DT = 0.01
"""[s]"""
NAME = ("cf1",)
CARRIED = np.ones(1, np.bool_)
"""One vehicle, by its rotors."""
NO_SLOPE = ResidualProcess(floor=0.5, slope=0.0)


def seen(t: float, height: float, acc: float = 0.0, fresh: bool = True) -> Measurement:
    """Return a measurement of one vehicle."""
    pos, zero = np.array([[0.0, 0.0, height]]), np.zeros((1, 3))
    return Measurement(t, NAME, MeasuredRows(pos, zero, np.array([[0.0, 0.0, acc]]), np.array([fresh])))


def run(
    observer: ResidualObserver, height: Array, push: Array | None = None, eta: float = 0.0, age: int = 0
) -> Array:
    """Return the states of a vehicle at heights (k,), felt to be pushed by (k,) `age` ticks ago, (k, 5)."""
    states = np.empty((height.size, 5))
    for k, z in enumerate(height):
        states[k] = observer.update(seen(k * DT, z), np.array([eta]), CARRIED)[0]
        if push is not None and k >= age:
            observer.correct_by_accelerometer((k - age) * DT, push[[k - age]])
    return states


def steady_gain(process: ResidualProcess) -> float:
    """Return k [-] of the accelerometer alone in clear air, by the Riccati equation."""
    share, one = process.correlation(DT), np.ones((1, 1))
    lost, noise = (1.0 - share**2) * process.floor**2, process.noise**2
    P = solve_discrete_are(share * one, one, lost * one, noise * one)
    return float(P[0, 0] / (P[0, 0] + noise))


def test_a_step_of_the_push_is_followed_by_the_poles_of_the_riccati_equation() -> None:
    """A vehicle starts to be pushed by 1 m/s^2; the estimates of two methods agree."""
    a = NO_SLOPE.correlation(DT)
    F = np.diag([1.0, 1.0, a, 1.0, 1.0])
    F[0, 1:4], F[1, 2:4] = [DT, DT**2 / 2, DT**2 / 2], DT
    H = np.array([[1.0, 0, 0, 0, 0], [0, 0, 1, 1, 1]])
    offset, bias = 2 * DT / OFFSET_S * OFFSET_STD**2, 2 * DT / BIAS_S * BIAS_STD**2
    Q = np.diag([0.0, 0.0, (1 - a**2) * NO_SLOPE.floor**2, offset, bias])
    R = np.diag([HEIGHT_STD**2, NO_SLOPE.noise**2])
    P = solve_discrete_are(F.T, H.T, Q, R)
    gain = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    k = np.arange(2100)
    push = np.where(k >= 2000, 1.0, 0.0)
    height = np.where(k >= 2000, 0.5 * ((k - 2000) * DT) ** 2, 0.0)
    observer, x = ResidualObserver(NO_SLOPE), np.zeros(5)
    for i in k:
        observer.update(seen(i * DT, height[i]), np.zeros(1), CARRIED)
        observer.correct_by_accelerometer(i * DT, push[[i]])
        ahead = F @ x
        x = ahead + gain @ (np.array([height[i], push[i]]) - H @ ahead)
        np.testing.assert_allclose(observer.estimate.state[0], x, atol=1e-6)
    assert x[RESIDUAL] + x[OFFSET] == pytest.approx(1.0, abs=0.05)
    assert x[CLIMB] == pytest.approx(99 * DT, abs=0.02)


def test_noise_of_the_accelerometer_reaches_the_estimate_with_the_variance_of_the_filter() -> None:
    """Of white noise of variance R, k^2 R / (1 - a^2 (1 - k)^2) is left; that bounds the noise of thrust."""
    rng, ticks = np.random.default_rng(2), 20000
    a, gain = REAL_FLIGHTS.correlation(DT), steady_gain(REAL_FLIGHTS)
    noise = REAL_FLIGHTS.noise * rng.standard_normal(ticks)
    alone = np.asarray(lfilter([gain], [1.0, -a * (1.0 - gain)], noise))
    expected = gain**2 * REAL_FLIGHTS.noise**2 / (1.0 - a**2 * (1.0 - gain) ** 2)
    assert alone.var() == pytest.approx(expected, rel=0.05)  # 1000 correlation times
    states = run(ResidualObserver(REAL_FLIGHTS), np.zeros(ticks), noise)
    total = states[500:, RESIDUAL] + states[500:, OFFSET]
    assert total.var() < expected  # positions separate noise from motion
    assert total.std() < 0.012 * GRAVITY


def test_a_bias_of_the_accelerometer_is_told_from_a_push_by_the_positions() -> None:
    """A vehicle hovers still and feels 0.1 m/s^2: within 10 s less than a tenth is taken for a push."""
    states = run(ResidualObserver(REAL_FLIGHTS), np.zeros(2000), np.full(2000, BIAS_STD))
    taken = states[:, RESIDUAL] + states[:, OFFSET]
    assert np.abs(taken[1000:]).max() < 0.1 * BIAS_STD
    assert states[-1, BIAS] == pytest.approx(BIAS_STD, rel=0.1)


def test_without_accelerometer_the_positions_alone_find_a_push() -> None:
    t = np.arange(300) * DT
    silent, never = ResidualObserver(NO_SLOPE), ResidualObserver(NO_SLOPE)
    found = run(silent, -0.25 * t**2)
    unknown = run(never, -0.25 * t**2, np.full(300, np.nan))
    np.testing.assert_array_equal(found, unknown)
    assert found[-1, RESIDUAL] + found[-1, OFFSET] == pytest.approx(-0.5, abs=0.02)
    assert found[-1, CLIMB] == pytest.approx(-0.5 * t[-1], abs=0.01)


def test_an_older_sample_weighs_less_and_one_too_old_nothing() -> None:
    steps = []
    for age in (0, 5, 15):
        observer = ResidualObserver(NO_SLOPE)
        run(observer, np.zeros(40))
        before = observer.estimate.state[0].copy()
        observer.correct_by_accelerometer((39 - age) * DT, np.ones(1))
        steps.append(float((observer.estimate.state[0] - before)[RESIDUAL]))
    assert steps[0] > 2.0 * steps[1] > 4.0 * steps[2] > 0.0
    observer.correct_by_accelerometer(40 * DT, np.ones(1))  # of the future
    fresh = ResidualObserver(NO_SLOPE)
    run(fresh, np.zeros(40))
    fresh.correct_by_accelerometer(39 * DT - OLDEST - DT, np.ones(1))
    np.testing.assert_array_equal(fresh.estimate.state[0, [RESIDUAL, OFFSET]], [0.0, 0.0])


def test_a_silent_vehicle_is_left_to_the_model_within_the_correlation_time() -> None:
    observer = ResidualObserver(NO_SLOPE)
    t = np.arange(100) * DT
    run(observer, 0.5 * t**2, np.ones(100))
    before = observer.estimate.state[0].copy()
    for k in range(100, 140):
        observer.update(seen(k * DT, np.nan, fresh=False), np.zeros(1), CARRIED)
    after = observer.estimate.state[0]
    assert after[RESIDUAL] == pytest.approx(before[RESIDUAL] * NO_SLOPE.correlation(0.4), rel=1e-9)
    assert after[OFFSET] == pytest.approx(before[OFFSET], rel=1e-12)
    assert np.isfinite(after[HEIGHT])


@pytest.mark.parametrize("climb", [0.0, -0.3])
def test_a_dip_of_the_thrust_is_a_pause_in_which_the_offset_stays(climb: float) -> None:
    """Positions do not correct it either: on the ground they contradict the thrust."""
    observer = ResidualObserver(NO_SLOPE)
    run(observer, np.zeros(500), np.ones(500))
    before = observer.estimate.state[0].copy()
    for k in range(500, 530):
        measured = seen(k * DT, climb * DT * (k - 499), acc=-GRAVITY)
        measured.rows.vel[:, 2] = climb
        observer.update(measured, np.zeros(1), ~CARRIED)
    after = observer.estimate.state[0]
    assert after[RESIDUAL] == pytest.approx(before[RESIDUAL] * NO_SLOPE.correlation(0.3), rel=1e-9)
    assert after[OFFSET] == pytest.approx(before[OFFSET], rel=1e-12)
    np.testing.assert_allclose(after[[HEIGHT, CLIMB]], [climb * 0.3, climb], atol=1e-12)


def tick(t: float, tilt: float, acc: float) -> ExplainedTick:
    """Return a tick of one vehicle that is tilted [rad]."""
    return ExplainedTick(
        t, NAME, quat_from_euler(np.array([tilt]), np.zeros(1), np.zeros(1)), np.array([acc])
    )


def test_a_push_is_felt_along_the_vertical_of_its_own_tick_whichever_comes_first() -> None:
    felt, force = AccelerometerResidual(), np.array([[0.0, 0.0, 11.0]])
    early = SwarmImu(0.02, NAME, force, np.zeros((1, 3)))
    assert felt.sense(early) is None
    assert felt.explain(tick(0.01, 0.0, GRAVITY)) is None
    found = felt.explain(tick(0.02, 0.3, GRAVITY))
    assert found is not None
    np.testing.assert_allclose(found[1], 11.0 * np.cos(0.3) - GRAVITY, rtol=1e-12)
    felt.explain(tick(0.03, 0.0, 0.0))
    late = felt.sense(
        SwarmImu(0.01, ("cf2", "cf1"), np.array([[9.0, 9.0, 9.0], [0.0, 0.0, 10.0]]), np.zeros((2, 3)))
    )
    assert late is not None
    np.testing.assert_allclose(late[1], 10.0 - GRAVITY, rtol=1e-12)
    other = felt.sense(SwarmImu(0.03, ("cf2",), force, np.zeros((1, 3))))
    assert other is not None
    assert np.isnan(other[1]).all()


def test_thrust_that_a_battery_withholds_for_seconds_winds_nothing_up() -> None:
    """Rotors give 2 m/s^2 less than commanded for 3 s; half a second later a tenth of it is left."""
    observer = ResidualObserver(REAL_FLIGHTS)
    t = np.arange(500) * DT
    push = np.where((t >= 1.0) & (t < 4.0), -2.0, 0.0)
    climb = np.concatenate([[0.0], np.cumsum(push[:-1]) * DT])
    height = np.concatenate([[0.0], np.cumsum(climb[:-1] * DT + 0.5 * push[:-1] * DT**2)])
    states = run(observer, height, push)
    found = states[:, RESIDUAL] + states[:, OFFSET]
    assert found[399] == pytest.approx(-2.0, abs=0.1)
    assert abs(found[450]) < 0.2
    assert np.abs(found[450:]).max() < 0.2
