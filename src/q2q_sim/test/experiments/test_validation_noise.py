"""Bands, noise and drag of recorded motion, and intervals over draws, against closed forms."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from turbulent_passes import recorded_passes

from q2q_model.flights.first_order_lag import first_order_lag
from q2q_model.geometry.rotations import UP, identity_quat, rotate
from q2q_sim.experiments.validation.error_figures import spectrum_figure
from q2q_sim.experiments.validation.error_spectrum import EDGES, band_power, segment_share
from q2q_sim.experiments.validation.error_statistics import comparison, error_sums, flight_intervals
from q2q_sim.experiments.validation.recorded.estimate_noise import colour_noise, estimate_noise, noise_density
from q2q_sim.experiments.validation.recorded.rotor_drag import drag_acceleration, read_drag
from q2q_sim.experiments.validation.recorded.tracked_flight import TrackedFlight

DT = 0.01
"""Time between samples [s]."""


def test_a_sine_has_half_its_squared_amplitude_in_its_band() -> None:
    t = DT * np.arange(2048)
    power = band_power(0.03 * np.sin(2.0 * np.pi * 1.1 * t), DT)
    band = int(np.searchsorted(EDGES, 1.1)) - 1
    np.testing.assert_allclose(power[:, band], 0.03**2 / 2.0, rtol=0.01)
    assert np.delete(power, band, axis=1).max() < 1e-2 * power[:, band].min()


def test_white_noise_fills_the_bands_by_their_width() -> None:
    noise = np.random.default_rng(0).standard_normal(200_000)
    power = band_power(noise, DT).mean(axis=0)
    np.testing.assert_allclose(power[2:], np.diff(EDGES)[2:] * 2.0 * DT, rtol=0.05)


@pytest.mark.parametrize("seconds", [10.0, 100.0])
def test_the_spectrum_of_white_noise_is_its_density_however_long_the_flight(seconds: float) -> None:
    rng, ticks = np.random.default_rng(0), round(seconds / DT)
    recorded, drawn = 0.01 * rng.standard_normal(ticks), 0.01 * rng.standard_normal((5, ticks))
    part = error_sums(recorded, drawn, np.ones(ticks, dtype=bool), DT, 0.95)
    (axes,) = spectrum_figure([part, part], "made").axes
    for stairs in axes.patches:
        density = stairs.get_data().values[3:]
        np.testing.assert_allclose(density, 2.0 * DT, rtol=0.4)  # 1 cm: 2 dt cm^2; 6 lines of 3 segments


def test_the_share_of_a_segment_is_that_of_its_rows() -> None:
    rows = np.zeros(1024, dtype=bool)
    rows[:256] = True
    np.testing.assert_allclose(segment_share(rows, DT), [0.5, 0.0, 0.0])


def test_noise_without_an_accelerometer_is_read_above_the_motion() -> None:
    t = DT * np.arange(8192)[:, None, None]
    noise = 3e-4 * np.random.default_rng(0).standard_normal((8192, 1, 3))
    _, density = noise_density(np.sin(t) + noise, np.full(noise.shape, np.nan), 2, DT)
    np.testing.assert_allclose(density, 3e-4**2 * 2.0 * DT, rtol=0.1)


@pytest.mark.parametrize(("rate", "rows"), [(30.0, 151), (30.02, 201), (30.1, 255), (30.0, 256)])
def test_at_30_hz_noise_without_an_accelerometer_is_that_of_the_last_line(rate: float, rows: int) -> None:
    noise = 3e-4 * np.random.default_rng(0).standard_normal((rows, 2000, 1))
    _, density = noise_density(noise, np.full(noise.shape, np.nan), 2, 1.0 / rate)
    np.testing.assert_allclose(density.mean(), 3e-4**2 * 2.0 / rate, rtol=0.1)  # of 2000 lines


def test_motion_that_the_accelerometer_shows_is_no_noise() -> None:
    rng = np.random.default_rng(0)
    noise = 1e-4 * rng.standard_normal((8192, 1, 3))
    at = np.fft.rfftfreq(8192, DT)[:, None, None]
    moved = np.fft.rfft(rng.standard_normal(noise.shape), axis=0) * ((at > 4.0) & (at < 10.0))
    for order in (1, 2):
        values = np.fft.irfft(moved / (2j * np.pi * np.maximum(at, 1.0)) ** order, axis=0)
        assert values.std() > 2e-4
        _, density = noise_density(values + noise, np.fft.irfft(moved, axis=0), order, DT)
        np.testing.assert_allclose(density[30:].mean(axis=0), 1e-4**2 * 2.0 * DT, rtol=0.1)


def test_drawn_noise_has_the_density_that_was_read() -> None:
    rng = np.random.default_rng(0)
    slow = first_order_lag(rng.standard_normal((20_000, 3)), DT * np.arange(20_000), 0.03)[:, None]
    frequency, density = noise_density(slow, np.zeros(slow.shape), 2, DT)
    drawn = colour_noise(rng.standard_normal(slow.shape), frequency, density, DT)
    _, again = noise_density(drawn, np.zeros(slow.shape), 2, DT)
    read = frequency > 3.2
    np.testing.assert_allclose(again[read].mean(), density[read].mean(), rtol=0.1)
    np.testing.assert_allclose(again[-10:].mean(), density[-10:].mean(), rtol=0.2)


def test_drag_slows_a_vehicle_across_its_thrust_alone() -> None:
    level = identity_quat((1,))
    np.testing.assert_allclose(
        drag_acceleration(0.4, np.array([[1.0, -2.0, 3.0]]), level), [[-0.4, 0.8, 0.0]], atol=1e-12
    )


def test_draws_of_one_process_hold_a_further_one_at_95_percent() -> None:
    rng = np.random.default_rng(0)
    drawn, rows = rng.standard_normal((20, 4000)), np.ones(4000, dtype=bool)
    found = comparison([error_sums(rng.standard_normal(4000), drawn, rows, DT, 0.5)])
    assert found.coverage95 == pytest.approx(0.95, abs=0.01)
    assert found.z_rms_ratio == pytest.approx(1.0, abs=0.03)
    assert found.spectrum_db == pytest.approx(0.0, abs=1.5)


def test_pooled_numbers_are_those_of_the_joined_rows() -> None:
    rng = np.random.default_rng(2)
    whole, drawn = rng.standard_normal(2000), rng.standard_normal((5, 2000))
    first = np.arange(2000) < 700
    split = [error_sums(whole, drawn, rows, DT, 2.0) for rows in (first, ~first)]
    together = error_sums(whole, drawn, np.ones(2000, dtype=bool), DT, 2.0)
    assert asdict(comparison(split)) == pytest.approx(asdict(comparison([together])))


def test_intervals_over_equal_flights_have_no_width() -> None:
    rng = np.random.default_rng(3)
    one = error_sums(
        rng.standard_normal(900), rng.standard_normal((5, 900)), np.ones(900, dtype=bool), DT, 0.5
    )
    low, high = flight_intervals([[one]] * 4)["z_rms_ratio"]
    assert low == pytest.approx(high)
    assert flight_intervals([[one]] * 2) == {}


@pytest.fixture(scope="module")
def flight() -> TrackedFlight:
    """Return a flight in the air of strength 1."""
    return recorded_passes()


def test_a_flight_too_slow_for_its_noise_is_refused(flight: TrackedFlight) -> None:
    slow = replace(flight, dt=0.04)
    with pytest.raises(
        ValueError, match=r"flight passes .* above 15 Hz; its rate of 25 Hz must be at least 30 Hz"
    ):
        estimate_noise(slow, 0)
    felt = replace(slow, acc=np.random.default_rng(0).standard_normal(flight.pos.shape))
    assert np.isfinite(estimate_noise(felt, 0)).all()  # read above 3.2 Hz
    for dt in (1.0 / 32.0, 1.0 / 30.0 + 1e-12):  # of stamps that rounding makes differ
        assert np.isfinite(estimate_noise(replace(flight, dt=dt), 0)).all()


def test_the_drag_of_the_rotors_is_read_from_the_accelerometer(flight: TrackedFlight) -> None:
    tilt = 0.2 * np.sin(flight.t)[:, None]
    still = np.zeros_like(tilt)
    quat = np.stack([still, np.sin(tilt / 2.0), still, np.cos(tilt / 2.0)], axis=-1) * np.ones(
        (1, 2, 1)
    )  # pitch
    thrust = 9.81 * rotate(quat, UP) - np.array([0.0, 0.0, 9.81])
    bias = 0.1 * rotate(quat, np.array([1.0, 0.0, 0.0]))
    moving = replace(
        flight,
        quat=quat,
        free=np.ones_like(flight.free),
        acc=thrust + bias + drag_acceleration(0.4, flight.vel, quat),
    )
    assert read_drag(moving) == pytest.approx(0.4, rel=1e-6)
    assert read_drag(flight) == 0.0  # it has no accelerometer
