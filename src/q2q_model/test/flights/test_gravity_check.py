"""Vertical accelerations with gravity in them are doubted by vehicle, for flights of some seconds."""

import numpy as np
import pytest

from q2q_model.flights.units_and_frames.gravity_check import gravity_note
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY

T = np.arange(0.0, 5.0, 0.01)


def readings(*medians: float) -> Array:
    """Return accelerations that vary around a value for each vehicle, (T, n)."""
    return np.array(medians) + np.random.default_rng(0).normal(scale=0.2, size=(len(T), 1))


@pytest.mark.parametrize("median", [1.0, -1.0, GRAVITY, -GRAVITY])
def test_gravity_of_either_sign_in_g_or_in_si_is_doubted(median: float) -> None:
    note = gravity_note(T, ("cf1", "cf2"), readings(0.0, median))
    assert "cf1" not in note
    assert f"{np.median(readings(median)):.2f} m/s^2 (cf2)" in note


@pytest.mark.parametrize("median", [0.0, 0.5, -3.0, np.nan])
def test_other_accelerations_are_not_doubted(median: float) -> None:
    assert not gravity_note(T, ("cf1",), readings(median))


def test_all_vehicles_are_named() -> None:
    note = gravity_note(T, ("cf1", "cf2"), readings(1.0, GRAVITY))
    assert "(cf1)" in note
    assert "(cf2)" in note


def test_a_short_flight_may_accelerate_throughout() -> None:
    assert not gravity_note(T[:60], ("cf1",), readings(1.0)[:60])
