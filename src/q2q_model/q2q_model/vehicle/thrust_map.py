"""Thrust that a Crazyflie's firmware gives per PWM.

Every build compensates for the battery, and so gives a force that is linear in PWM, f = f_full PWM / 65535
for each of four motors (bitcraze/crazyflie-firmware, src/drivers/src/motors.c). f_full [N] changed:

| firmware | releases and build | brushed | Brushless | source |
|---|---|---|---|---|
| stock | 2025.12.1 to 2026.08, default build | 0.12 | 0.2 | platform_defaults_cf2.h, _cf21bl.h: THRUST_MAX |
| thrust_upgrade | the same, CONFIG_CRAZYFLIE_THRUST_UPGRADE_KIT | 0.18 | | the same |
| stock_2025_09 | 2025.09 to 2025.12 | 0.1125 | 0.1625 | the same, at these tags |
| stock_2025_02 | before 2025.09 | 0.1471 | | motors.c: 60 gram-force of all four motors |

The figure of 60 gram-force is the collective thrust: its fit (0 to 57.9 g) is a whole vehicle on a scale
(firmware, docs/functional-areas/pwm-to-thrust.md), so a motor gives 15. The Brushless of 2025.09 borrowed the
upgrade kit's number (2025.12 has its own, 0.2), and before that it compensated nothing.

A vehicle that is no Crazyflie has a map of its own.
"""

from collections.abc import Mapping

PWM_FULL = 65535
"""Full duty of a motor [PWM]."""
PWM_STICK_MAX = 60000
"""Largest thrust that the Crazyflie's commander takes from an RPYT setpoint [PWM]."""
MASS_THRUST = 132000.0
"""PWM of every motor per newton of collective thrust that ctrlMel.massThrust has on every build [1/N]."""
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
    """Return f_full [N]; None for a vehicle with a map of its own.

    Raises:
        ValueError: a firmware that the vehicle does not have.
    """
    known = MOTOR_THRUST.get(vehicle, {})
    if firmware not in known and (known or firmware != STOCK):
        raise ValueError(f"firmware {firmware!r} of {vehicle}: known are {', '.join(known) or STOCK}")
    return known.get(firmware)
