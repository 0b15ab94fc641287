"""LiPo cell with voltage and level as the firmware reports them.

| number | source |
|---|---|
| charge curve: voltage at 0, 10 .. 90 % | firmware: hal/src/pm_stm32f4.c, LiPoTypicalChargeCurve |
| full at 4.2 V | the same |
| 7 minutes of hover from full to empty | Bitcraze's data sheet of the Crazyflie 2.x |
| low after 5 s below pm.lowVoltage | firmware: DEFAULT_BAT_LOW_DURATION_TO_TRIGGER_SEC |

Thrust falls with the voltage only at full duty: below, the firmware compensates (thrust_curve). The voltage
does not sag under load.
"""

import numpy as np

VOLT_FULL = 4.2
"""[V]"""
CURVE_CHARGE = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
CURVE_VOLT = np.array([3.00, 3.78, 3.83, 3.87, 3.89, 3.92, 3.96, 4.00, 4.04, 4.10, VOLT_FULL])
HOVER_TIME = 420.0
"""[s]"""
LOW_TIME = 5.0
"""[s]"""
ON_BATTERY, LOW_POWER = 0, 3
"""pm.state."""


class Battery:
    """Charge of the battery."""

    def __init__(self) -> None:
        self.charge = 1.0
        """0 to 1."""
        self._low_for = 0.0

    @property
    def volt(self) -> float:
        """Return the voltage [V]."""
        return float(np.interp(self.charge, CURVE_CHARGE, CURVE_VOLT))

    @property
    def level(self) -> int:
        """Return the level [%], in steps of 10."""
        return int(np.count_nonzero(self.volt > CURVE_VOLT[:10]) * 10) if self.volt <= CURVE_VOLT[9] else 90

    @property
    def state(self) -> int:
        """Return pm.state."""
        return LOW_POWER if self._low_for > LOW_TIME else ON_BATTERY

    def drain(self, hovers: float, dt: float, low_volt: float) -> None:
        """Discharge for `dt` [s] at a thrust of `hovers` times the weight."""
        self.charge = max(self.charge - hovers * dt / HOVER_TIME, 0.0)
        self._low_for = self._low_for + dt if self.volt <= low_volt else 0.0
