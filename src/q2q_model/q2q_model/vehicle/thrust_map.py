"""Thrust per PWM of the Crazyflie firmware.

Every build compensates the battery voltage, so thrust is linear in PWM: f = f_full PWM / 65535 for each of
four motors (bitcraze/crazyflie-firmware, src/drivers/src/motors.c). f_full [N] differs between releases:

| firmware | releases and build | brushed | Brushless | source |
|---|---|---|---|---|
| stock | 2025.12.1 to 2026.08, default build | 0.12 | 0.2 | platform_defaults_cf2.h, _cf21bl.h: THRUST_MAX |
| thrust_upgrade | the same, CONFIG_CRAZYFLIE_THRUST_UPGRADE_KIT | 0.18 | | the same |
| stock_2025_09 | 2025.09 to 2025.12 | 0.1125 | 0.1625 | the same, at these tags |
| stock_2025_02 | before 2025.09 | 0.1471 | | motors.c: 60 gram-force of all four motors |

60 gram-force is the collective thrust: it was fitted (0 to 57.9 g) to a whole vehicle on a scale (firmware,
docs/functional-areas/pwm-to-thrust.md), so each motor gives 15. In 2025.09 the Brushless used the upgrade
kit's value (2025.12 has its own, 0.2); earlier releases do not compensate its battery.

Vehicles other than Crazyflies have their own map.
"""

from collections.abc import Mapping

PWM_FULL = 65535
"""Full duty of a motor [PWM]."""
RPYT_PWM_MIN, RPYT_PWM_MAX = 1000, 60000
"""Least thrust of an RPYT setpoint for which the Crazyflie's commander turns the motors (its MIN_THRUST), and
the largest that it accepts [PWM]."""
MASS_THRUST = 132000.0
"""Default of ctrlMel.massThrust on every build: motor PWM per newton of collective thrust [1/N]."""
STOCK = "stock"
GRAM_FORCE = 9.81e-3
"""[N]"""

BRUSHED_MOTOR, BRUSHLESS_MOTOR = 0.12, 0.2
"""f_full of the stock firmware [N]."""
_BRUSHED: Mapping[str, float] = {
    STOCK: BRUSHED_MOTOR,
    "thrust_upgrade": 0.18,
    "stock_2025_09": 0.1125,
    "stock_2025_02": 15.0 * GRAM_FORCE,
}
MOTOR_THRUST: Mapping[str, Mapping[str, float]] = {
    "crazyflie_2_0": _BRUSHED,
    "crazyflie_2_1": _BRUSHED,
    "crazyflie_2_1_plus": _BRUSHED,
    "crazyflie_brushless": {STOCK: BRUSHLESS_MOTOR, "stock_2025_09": 0.1625},
}
"""f_full of each vehicle on each firmware [N]."""
FIRMWARES = tuple(_BRUSHED)


def motor_thrust(vehicle: str, firmware: str) -> float | None:
    """Return f_full [N]; None for a vehicle with its own map.

    Raises:
        ValueError: a firmware that the vehicle does not have.
    """
    known = MOTOR_THRUST.get(vehicle, {})
    if firmware not in known and (known or firmware != STOCK):
        raise ValueError(
            f"unknown firmware {firmware!r} of {vehicle}; choose one of {', '.join(known) or STOCK}"
        )
    return known.get(firmware)
