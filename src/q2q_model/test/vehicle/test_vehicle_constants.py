"""Constants of a vehicle that no vehicle has are refused."""

from dataclasses import replace

import pytest

from q2q_model.vehicle.constants import CRAZYFLIE_2_1


@pytest.mark.parametrize(
    ("field", "value", "bound"),
    [
        ("mass", 0.0, "above 0"),
        ("mass", -0.03, "above 0"),
        ("mass", float("nan"), "above 0"),
        ("inertia", (1e-5, 0.0, 1e-5), "above 0"),
        ("thrust_max", float("inf"), "above 0"),
        ("thrust_lag", -0.1, "at least 0"),
        ("thrust_lag", float("nan"), "at least 0"),
    ],
)
def test_a_constant_that_no_vehicle_has_is_refused(field: str, value: object, bound: str) -> None:
    with pytest.raises(
        ValueError, match=rf"^vehicle crazyflie_2_1: {field} = .*; must be finite and {bound}$"
    ):
        replace(CRAZYFLIE_2_1, **{field: value})


def test_a_vehicle_may_have_no_lag() -> None:
    assert replace(CRAZYFLIE_2_1, thrust_lag=0.0).thrust_lag == 0.0
