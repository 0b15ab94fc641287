"""A hovering vehicle of the emulated firmware, for tests."""

import numpy as np

from cflib_fleet import CflibFleet
from q2q_sim.firmware.commander.setpoint import Mode, Setpoint
from q2q_sim.firmware.firmware_build import Build

HOVER = Setpoint(x=Mode.ABS, y=Mode.ABS, z=Mode.ABS, yaw=Mode.ABS, pos=(0.0, 0.0, 1.0))


def hovering(**build: bool) -> CflibFleet:
    """Return a vehicle that has hovered for 3 s."""
    crazyflies = CflibFleet(np.array([[0.0, 0.0, 1.0, 0.0]]), build=Build(**build))
    crazyflies.fly(3.0, crazyflies.hold(HOVER))
    return crazyflies
