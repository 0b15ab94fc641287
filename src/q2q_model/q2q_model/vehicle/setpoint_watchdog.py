"""Watchdog of the Crazyflie's commander, which acts on vehicles without newer setpoints."""

LEVEL_AFTER_S = 0.5
"""Age of a setpoint from which a vehicle levels out [s]: COMMANDER_WDT_TIMEOUT_STABILIZE of the firmware."""
CUT_AFTER_S = 2.0
"""Age from which its motors are off, and locked [s]: COMMANDER_WDT_TIMEOUT_SHUTDOWN of the firmware."""
