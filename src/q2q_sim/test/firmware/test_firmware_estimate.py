"""The estimate of the emulated firmware, its resets, and its battery."""

import numpy as np
import pytest

from cflib_fleet import CflibFleet
from q2q_sim.firmware.estimator import Estimator
from q2q_sim.firmware.firmware_build import Build
from q2q_sim.firmware.motors.battery import LOW_POWER, Battery


def test_the_estimate_follows_external_positions_and_knows_how_sure_it_is() -> None:
    truth, noise = np.array([1.0, 2.0, 0.5]), np.array([0.5, 0.5, 1.0])
    one = Estimator(np.zeros(6))
    one.forget(np.zeros(3), truth)
    np.testing.assert_allclose(one.drift[:3], -truth)
    one.correct(truth, truth, 0.01)
    np.testing.assert_allclose(one.drift[:3], 0.0, atol=1e-3)  # 100 m (z: 1 m) of doubt against 1 cm
    sure = one.variance[:3].max()
    for _ in range(100):
        one.predict(noise)
    assert one.variance[:3].min() > sure
    rng = np.random.default_rng(0)
    errors = []
    for _ in range(2000):
        one.predict(noise)
        one.correct(truth + 0.01 * rng.standard_normal(3), truth, 0.01)
        errors.append(one.drift[:3].copy())
    measured = np.var(errors[200:], axis=0)
    assert (measured < one.variance[:3]).all()  # a still vehicle is better known than the filter dares to say
    assert (one.variance[:3] < 0.01**2).all()


def test_process_noise_grows_each_millisecond_on_the_diagonal_within_bounds() -> None:
    one, q = Estimator(np.zeros(6)), np.array([0.5, 0.5, 1.0])
    np.testing.assert_allclose(one.variance, [1e4, 1e4, 1.0, 1e-4, 1e-4, 1e-4])
    one.predict(q)
    velocity = 1e-4 + 10 * (q * 1e-3) ** 2
    np.testing.assert_allclose(one.variance[3:], velocity, rtol=1e-12)
    height = 1.0 + 0.01**2 * 1e-4 + 10 * (1e-6) ** 2
    np.testing.assert_allclose(one.variance[:3], [100.0, 100.0, height], rtol=1e-12)
    for _ in range(3):
        one.correct(np.zeros(3), np.zeros(3), 1e-5)
    np.testing.assert_allclose(one.variance[:3], 1e-6, rtol=1e-12)


def test_a_reset_of_the_estimate_happens_once(grounded: CflibFleet) -> None:
    firmware = grounded.firmware()
    firmware.parameters.set("kalman.initialX", 2.0)
    firmware.parameters.set("kalman.resetEstimation", 1)
    grounded.fly(0.01)
    assert firmware.parameters["kalman.resetEstimation"] == 0
    grounded.fly(0.5)
    assert firmware.rows.pos[0] == pytest.approx(0.0, abs=1e-3)  # the deck has corrected it


def test_external_positions_matter_without_a_deck_only() -> None:
    for deck in (True, False):
        crazyflies = CflibFleet(np.zeros((1, 4)), build=Build(positioning_deck=deck))
        crazyflies.fly(1.0, lambda _, one=crazyflies: one.firmware().locate((3.0, 4.0, 0.0)))
        expected = [0.0, 0.0] if deck else [3.0, 4.0]
        np.testing.assert_allclose(crazyflies.firmware().rows.pos[:2], expected, atol=1e-2)


def test_a_battery_lasts_for_its_hover_time_and_says_when_it_is_low() -> None:
    one = Battery()
    assert (one.volt, one.level) == (4.2, 90)
    for _ in range(4200):
        one.drain(1.0, 0.05, 3.2)
    assert (one.volt, one.level) == (pytest.approx(3.92, abs=0.01), pytest.approx(55, abs=5))
    for _ in range(4200):
        one.drain(1.0, 0.05, 3.2)
    assert one.volt == pytest.approx(3.0)
    assert one.state == LOW_POWER
