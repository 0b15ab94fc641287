"""Firmware parameters that a vehicle must hold."""

import pytest

from q2q_control.radio.link.firmware_params import first_difference

RESET = "kalman.resetEstimation"


@pytest.mark.parametrize("found", [0.0, 1.0])
def test_a_parameter_that_the_firmware_sets_back_is_held_before_and_after(found: float) -> None:
    """The vehicle was refused where it had been set back before it was read: 1 of 10 take-offs."""
    assert first_difference({RESET: 1.0}, {RESET: found}) == ""


def test_a_parameter_that_the_firmware_sets_back_must_be_of_a_vehicle_all_the_same() -> None:
    assert "is nan, expected 1" in first_difference({RESET: 1.0}, {})
    assert "is 2, expected 1" in first_difference({RESET: 1.0}, {RESET: 2.0})
    assert "is 0, expected 2" in first_difference(
        {"stabilizer.controller": 2.0}, {"stabilizer.controller": 0.0}
    )
