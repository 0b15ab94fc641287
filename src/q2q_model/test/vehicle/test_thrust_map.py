"""The table of vehicle and firmware gives the forces and hovers that the firmware gives."""

import pytest

from q2q_model.vehicle.constants import CRAZYFLIE_2_0, TEXTBOOK_065, VEHICLES, on_firmware, vehicle_by_name
from q2q_model.vehicle.hover_thrust import OwnHover, hover_pwm, hover_ratio
from q2q_model.vehicle.thrust_map import FIRMWARES, MASS_THRUST, MOTOR_THRUST

RPYT_SHARE = 60000 / 65535


@pytest.mark.parametrize(
    ("firmware", "newtons"),
    [
        ("stock", 0.4395),
        ("thrust_upgrade", 0.6592),
        ("stock_2025_09", 0.4120),
        ("stock_2025_02", 0.5389),  # 60 gram-force of the whole vehicle at 65535
    ],
)
def test_the_largest_rpyt_thrust_gives_what_the_firmware_gives(firmware: str, newtons: float) -> None:
    vehicle = vehicle_by_name("crazyflie_2_0", firmware)
    assert vehicle.rpyt_thrust_max == pytest.approx(newtons, abs=5e-5)  # four decimals
    assert vehicle.thrust_max == vehicle.full_pwm_thrust == pytest.approx(newtons / RPYT_SHARE, abs=1e-4)


def test_34_grams_hover_at_45539_on_the_stock_firmware_which_is_the_default() -> None:
    assert round(hover_pwm(CRAZYFLIE_2_0)) == 45539
    assert vehicle_by_name("crazyflie_2_0") == on_firmware(CRAZYFLIE_2_0, "stock") == CRAZYFLIE_2_0


def test_every_vehicle_hovers_within_its_rpyt_setpoints_on_every_firmware_it_has() -> None:
    for name, vehicle in VEHICLES.items():
        for firmware in MOTOR_THRUST.get(name, ("stock",)):
            one = on_firmware(vehicle, firmware)
            assert one.hover_thrust < one.rpyt_thrust_max <= one.thrust_max
            assert (one.mass, one.inertia) == (vehicle.mass, vehicle.inertia)


def test_an_rpyt_setpoint_scaled_for_another_firmware_is_reported_by_the_vehicles_own_parameters() -> None:
    own = OwnHover(mass=0.034, mass_thrust=MASS_THRUST)
    ratios = {name: hover_ratio(vehicle_by_name("crazyflie_2_0", name), own) for name in FIRMWARES}
    assert ratios["stock"] == pytest.approx(65535 / 0.48 / 132000)  # 3 % above: the firmware's own rounding
    assert ratios["thrust_upgrade"] < 0.85
    assert ratios["stock_2025_02"] < 0.85
    assert hover_ratio(CRAZYFLIE_2_0, OwnHover(0.029, MASS_THRUST)) > 1.15  # guards that it knows nothing of


def test_the_right_mass_thrust_makes_both_agree_on_every_vehicle_and_firmware() -> None:
    for name in VEHICLES:
        for firmware in MOTOR_THRUST.get(name, ("stock",)):
            one = vehicle_by_name(name, firmware)
            assert hover_ratio(one, OwnHover(one.mass, 65535 / one.full_pwm_thrust)) == pytest.approx(1.0)
    brushless = vehicle_by_name("crazyflie_brushless")
    assert brushless.full_pwm_thrust == pytest.approx(0.8)  # 132000 is 61 % above 65535 / 0.8


def test_the_textbook_vehicle_has_a_map_of_its_own() -> None:
    assert TEXTBOOK_065.rpyt_thrust_max == pytest.approx(TEXTBOOK_065.thrust_max, rel=1e-15)
    assert on_firmware(TEXTBOOK_065, "stock") is TEXTBOOK_065


@pytest.mark.parametrize(
    ("vehicle", "firmware", "output"),
    [
        ("crazyflie_2_0", "2025", "choose one of stock, thrust_upgrade, stock_2025_09, stock_2025_02"),
        ("crazyflie_brushless", "thrust_upgrade", "choose one of stock, stock_2025_09"),
        ("textbook_065", "thrust_upgrade", "choose one of stock"),
    ],
)
def test_a_firmware_that_a_vehicle_does_not_have_is_refused_with_those_it_has(
    vehicle: str, firmware: str, output: str
) -> None:
    with pytest.raises(ValueError, match=f"unknown firmware '{firmware}' of {vehicle}; {output}"):
        vehicle_by_name(vehicle, firmware)


@pytest.mark.parametrize("own", [OwnHover(0.0, MASS_THRUST), OwnHover(0.034, float("nan"))])
def test_senseless_parameters_of_a_vehicle_are_an_infinite_mismatch(own: OwnHover) -> None:
    assert hover_ratio(CRAZYFLIE_2_0, own) == float("inf")
