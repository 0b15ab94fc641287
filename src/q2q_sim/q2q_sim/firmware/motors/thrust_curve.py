"""Thrust of a motor over its voltage, and the duty for a desired thrust, compiled.

Source: firmware: drivers/src/motors.c (motorsCompensateBatteryVoltage), the curve of the stock propellers
(2.1+) in platform/interface/platform_defaults_cf2.h; Bitcraze, "Keeping thrust consistent as the battery
drains", 2025. With the share of full thrust T = pwm / 65535:

    T(u) F = c0 + c1 u + c2 u^2 + c3 u^3        u = V duty / 65535: voltage at the motor
    duty   = 65535 u(T) / V_s                   Cardano's root; 0 below 7000 PWM, where u(T) is ambiguous

| symbol | name | meaning [unit] |
|---|---|---|
| c | CURVE | coefficients of the thrust of one motor [N/V^k] |
| F | BRUSHED_MOTOR | thrust of one motor at 65535 PWM [N] |
| V V_s | volt, supply | battery voltage, true and as the firmware measures it [V] |
"""

import math

from q2q_model.compiled import compiled
from q2q_model.vehicle.thrust_map import BRUSHED_MOTOR, PWM_FULL

PWM_TOP = float(PWM_FULL)
CURVE = (-0.02476537915958403, 0.06523793527519485, -0.026792504967750107, 0.006776789303971145)
PWM_STANDSTILL = 7000.0
"""Below, a compensated motor stops: THRUST_MIN over THRUST_MAX of every build, also brushless."""
SUPPLY_MIN = 2.0
"""Smallest valid supply reading; below it motors are off [V]."""

_SHIFT = -CURVE[2] / (3.0 * CURVE[3])
_SLOPE = CURVE[1] / (3.0 * CURVE[3]) - _SHIFT**2
_CONSTANT = _SHIFT**3 + CURVE[2] * CURVE[1] / (6.0 * CURVE[3] ** 2) - CURVE[0] / (2.0 * CURVE[3])
_PER_PWM = BRUSHED_MOTOR / PWM_TOP / (2.0 * CURVE[3])


@compiled
def compensate(pwm: float, supply: float) -> float:
    """Return the duty (65535 is 100 %) for the thrust command `pwm` at a supply [V]."""
    if pwm < PWM_STANDSTILL or not supply >= SUPPLY_MIN:
        return 0.0
    half = _CONSTANT + _PER_PWM * pwm
    root = math.sqrt(half * half + _SLOPE * _SLOPE * _SLOPE)
    volt = math.copysign(abs(half + root) ** (1.0 / 3.0), half + root)
    volt += math.copysign(abs(half - root) ** (1.0 / 3.0), half - root)
    return PWM_TOP * (volt + _SHIFT) / supply


@compiled
def thrust_pwm(duty: float, volt: float) -> float:
    """Return the thrust of a motor at a duty and a battery voltage [V], in PWM of thrust command."""
    u = volt * duty / PWM_TOP
    thrust = CURVE[0] + u * (CURVE[1] + u * (CURVE[2] + u * CURVE[3]))
    return max(thrust, 0.0) * PWM_TOP / BRUSHED_MOTOR
